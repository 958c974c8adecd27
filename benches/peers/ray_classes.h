// The ray file, and the four classes of rays that are measured.
//
// A ray file is little-endian: 8 bytes "A2RAYS1\0", the number of rays as u64, then per ray seven f32: origin x y z,
// direction x y z, tmax. Directions are unit vectors, tmin is 0, space is the mesh's own. Camera rays come in 8 x 8
// tiles made of 4 x 2 blocks, so that any 8 rays in a row are neighbours; shadow and mirror rays keep that order.
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "mesh_obj.h"

struct Ray {
    Vec3 origin, direction;
    float tmax;
};
static_assert(sizeof(Ray) == 28, "rays are read and written as they lie in memory");

constexpr char RAY_MAGIC[8] = "A2RAYS1";
constexpr float UNBOUNDED = std::numeric_limits<float>::max();

inline void write_rays(const std::string& path, const std::vector<Ray>& rays) {
    std::ofstream out(path, std::ios::binary);
    uint64_t count = rays.size();
    out.write(RAY_MAGIC, 8);
    out.write(reinterpret_cast<const char*>(&count), 8);
    out.write(reinterpret_cast<const char*>(rays.data()), std::streamsize(count * sizeof(Ray)));
    if (!out) throw std::runtime_error("cannot write " + path);
}

inline std::vector<Ray> read_rays(const std::string& path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) throw std::runtime_error("cannot open " + path);
    uint64_t bytes = uint64_t(in.tellg()), count = 0;
    char magic[8] = {};
    in.seekg(0);
    in.read(magic, 8);
    in.read(reinterpret_cast<char*>(&count), 8);
    if (!in || std::memcmp(magic, RAY_MAGIC, 8) != 0 || (bytes - 16) / sizeof(Ray) != count)
        throw std::runtime_error(path + " is not a ray file");
    std::vector<Ray> rays(count);
    in.read(reinterpret_cast<char*>(rays.data()), std::streamsize(count * sizeof(Ray)));
    return rays;
}

// The camera and the first light of a course scene, and the uniform scale and shift of its mesh.
struct View {
    Vec3 center, direction;
    float angle_degrees;
    Vec3 light_direction;
    float scale;
    Vec3 shift;
};

inline View view_named(const std::string& name) {
    if (name == "scene05") return {{0.35f, 0.6f, 0.8f}, {-0.5f, -0.5f, -1}, 25, {0.2f, -1, -0.4f}, 1, {0, 0, 0}};
    if (name == "scene06") return {{0, 0, 10}, {0, 0, -1}, 30, {-0.5f, -0.3f, -1}, 12, {0.5f, -2.6f, 0}};
    throw std::runtime_error("unknown view " + name + " (scene05, scene06)");
}

inline std::vector<Ray> camera_rays(const View& view, int size = 800) {
    Vec3 forward = unit(view.direction), up{0, 1, 0}, right = unit(cross(forward, up));
    Vec3 origin = (view.center - view.shift) * (1 / view.scale);
    float distance = 1 / std::tan(view.angle_degrees * float(M_PI) / 360);
    std::vector<Ray> rays;
    for (int tile = 0; tile < size / 8 * (size / 8); ++tile)
        for (int k = 0; k < 64; ++k) {
            int block = k / 8, x = tile % (size / 8) * 8 + block % 2 * 4 + k % 4;
            int y = tile / (size / 8) * 8 + block / 2 * 2 + k / 4 % 2;
            float ndc_x = 2 * float(x) / float(size - 1) - 1, ndc_y = 2 * float(y) / float(size - 1) - 1;
            rays.push_back({origin, unit(forward * distance + right * ndc_x + up * ndc_y), UNBOUNDED});
        }
    return rays;
}

// What a hit says of a ray: where on which triangle; `hit` false when it misses.
struct Hit {
    bool hit;
    float t, u, v;
    uint32_t triangle;
};
using ClosestHit = std::function<Hit(const Ray&)>;

// a2 moves the origin of a secondary ray by this much of the world's units along the ray.
constexpr float OFFSET = 0.01f;

inline std::vector<Ray> shadow_rays(const View& view, const ClosestHit& closest) {
    Vec3 to_light = unit(view.light_direction * -1);
    std::vector<Ray> rays;
    for (const Ray& ray : camera_rays(view))
        if (Hit h = closest(ray); h.hit) {
            Vec3 p = ray.origin + ray.direction * h.t;
            rays.push_back({p + to_light * (OFFSET / view.scale), to_light, UNBOUNDED});
        }
    return rays;
}

inline std::vector<Ray> mirror_rays(const View& view, const Mesh& mesh, const ClosestHit& closest) {
    std::vector<Vec3> normals = mesh.vertex_normals();
    for (Vec3& n : normals) n = unit(n);
    std::vector<Ray> rays;
    for (const Ray& ray : camera_rays(view))
        if (Hit h = closest(ray); h.hit) {
            auto [i, j, k] = mesh.triangles[h.triangle];
            Vec3 n = unit(normals[i] * (1 - h.u - h.v) + normals[j] * h.u + normals[k] * h.v);
            Vec3 mirrored = unit(ray.direction - n * (2 * dot(ray.direction, n)));
            Vec3 p = ray.origin + ray.direction * h.t;
            rays.push_back({p + mirrored * (OFFSET / view.scale), mirrored, UNBOUNDED});
        }
    return rays;
}

// Between two uniform points of the bounding sphere of the mesh's box. Drawn one by one, so in no order.
inline std::vector<Ray> random_rays(const Mesh& mesh, size_t count = 640000) {
    Vec3 low = mesh.vertices[0], high = low;
    for (Vec3 v : mesh.vertices) {
        low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
        high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
    Vec3 center = (low + high) * 0.5f, diagonal = high - low;
    float radius = 0.5f * std::sqrt(dot(diagonal, diagonal));
    std::mt19937 bits(1);
    auto uniform = [&] { return float(bits() >> 8) * (1.0f / 16777216.0f); };
    auto point = [&] {
        float z = 2 * uniform() - 1, azimuth = 2 * float(M_PI) * uniform(), r = std::sqrt(1 - z * z);
        return center + Vec3{r * std::cos(azimuth), r * std::sin(azimuth), z} * radius;
    };
    std::vector<Ray> rays;
    while (rays.size() < count) {
        Vec3 from = point(), to = point();
        if (Vec3 d = to - from; dot(d, d) > 0) rays.push_back({from, unit(d), UNBOUNDED});
    }
    return rays;
}
