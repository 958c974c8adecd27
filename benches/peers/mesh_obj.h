// Reads the positions and triangles of an OBJ file, and the vertex normals that a2 defines. Ignores everything else.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

struct Vec3 {
    float x, y, z;
};

inline Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator*(Vec3 a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 unit(Vec3 a) {
    float length = std::sqrt(dot(a, a));
    return length > 0 ? a * (1 / length) : a;
}

struct Triangle {
    uint32_t i, j, k;
};

struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    // Sums of the unit normals of the faces at each vertex, as a2 shades them; not normalised.
    std::vector<Vec3> vertex_normals() const {
        std::vector<Vec3> sums(vertices.size(), Vec3{0, 0, 0});
        for (auto [i, j, k] : triangles) {
            Vec3 n = unit(cross(vertices[j] - vertices[i], vertices[k] - vertices[i]));
            sums[i] = sums[i] + n;
            sums[j] = sums[j] + n;
            sums[k] = sums[k] + n;
        }
        return sums;
    }
};

inline Mesh load_obj(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw std::runtime_error("cannot open " + path);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const char *at = text.data(), *end = at + text.size();
    auto skip_blanks = [&] {
        while (at < end && (*at == ' ' || *at == '\t')) ++at;
    };
    auto number = [&](auto& value) {
        skip_blanks();
        auto [next, error] = std::from_chars(at, end, value);
        if (error != std::errc()) throw std::runtime_error("bad number in " + path);
        at = next;
    };
    Mesh mesh;
    while (at < end) {
        if (end - at > 1 && at[0] == 'v' && at[1] == ' ') {
            at += 2;
            Vec3 v;
            number(v.x), number(v.y), number(v.z);
            mesh.vertices.push_back(v);
        } else if (end - at > 1 && at[0] == 'f' && at[1] == ' ') {
            at += 2;
            std::vector<uint32_t> corners;
            for (skip_blanks(); at < end && *at != '\n' && *at != '\r'; skip_blanks()) {
                long index;
                number(index);
                long count = long(mesh.vertices.size());
                long corner = index > 0 ? index - 1 : count + index;
                if (corner < 0 || corner >= count) throw std::runtime_error("index out of range in " + path);
                corners.push_back(uint32_t(corner));
                while (at < end && *at > ' ') ++at;  // the texture and normal indices
            }
            for (size_t k = 2; k < corners.size(); ++k)
                mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
        }
        while (at < end && *at != '\n') ++at;
        if (at < end) ++at;
    }
    if (mesh.triangles.empty()) throw std::runtime_error("no triangles in " + path);
    return mesh;
}
