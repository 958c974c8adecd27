// Embree's speed on a mesh and a file of rays, and the maker of such files. See README.md for how it is used.

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <xmmintrin.h>

#include <atomic>
#include <chrono>
#include <iostream>
#include <thread>

#include "ray_classes.h"

static double seconds() {
    using namespace std::chrono;
    return duration<double>(steady_clock::now().time_since_epoch()).count();
}

struct Spread {
    double median, least, most;
};

static Spread spread(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    size_t n = values.size();
    return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back()};
}

static void fail(void*, RTCError, const char* message) {
    throw std::runtime_error(std::string("Embree: ") + message);
}

static RTCDevice new_device(int threads) {
    std::string config = "threads=" + std::to_string(threads);
    RTCDevice device = rtcNewDevice(config.c_str());
    if (!device) throw std::runtime_error("no Embree device");
    rtcSetDeviceErrorFunction(device, fail, nullptr);
    return device;
}

// `padded`: vertices with 4 readable bytes after the last one, as Embree's shared buffers want.
static RTCScene build(RTCDevice device, const Mesh& mesh, const std::vector<Vec3>& padded) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, padded.data(), 0, sizeof(Vec3),
                               mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               sizeof(Triangle), mesh.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

// Eight rays as one packet wants them: all x, all y, ...
struct Packet {
    alignas(32) float lane[7][8];
};

static std::vector<Packet> packets_of(const std::vector<Ray>& rays) {
    std::vector<Packet> packets((rays.size() + 7) / 8);
    for (size_t i = 0; i < packets.size() * 8; ++i) {
        Ray ray = rays[std::min(i, rays.size() - 1)];
        if (i >= rays.size()) ray.tmax = -1;  // filling: below tnear, so inactive
        float values[7];
        std::memcpy(values, &ray, sizeof values);
        for (int k = 0; k < 7; ++k) packets[i / 8].lane[k][i % 8] = values[k];
    }
    return packets;
}

static RTCRay ray1(const Ray& ray) {
    Vec3 o = ray.origin, d = ray.direction;
    return {o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, ray.tmax, ~0u, 0, 0};
}

static uint64_t intersect1(RTCScene scene, const Ray* rays, size_t count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    uint64_t hits = 0;
    for (size_t i = 0; i < count; ++i) {
        RTCRayHit q;
        q.ray = ray1(rays[i]);
        q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &q);
        hits += q.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

static uint64_t occluded1(RTCScene scene, const Ray* rays, size_t count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    uint64_t hits = 0;
    for (size_t i = 0; i < count; ++i) {
        RTCRay q = ray1(rays[i]);
        rtcOccluded1(scene, &context, &q);
        hits += q.tfar < 0;
    }
    return hits;
}

static void set_ray8(RTCRay8& ray, const Packet& p) {
    std::memcpy(ray.org_x, p.lane[0], 96);
    std::memcpy(ray.dir_x, p.lane[3], 96);
    std::memcpy(ray.tfar, p.lane[6], 32);
    std::memset(ray.tnear, 0, 32);
    std::memset(ray.time, 0, 32);
    std::memset(ray.mask, 0xff, 32);
    std::memset(ray.flags, 0, 32);
}

alignas(32) static const int ALL_LANES[8] = {-1, -1, -1, -1, -1, -1, -1, -1};

static uint64_t intersect8(RTCScene scene, const Packet* packets, size_t count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    uint64_t hits = 0;
    RTCRayHit8 q;
    for (size_t i = 0; i < count; ++i) {
        set_ray8(q.ray, packets[i]);
        std::memset(q.hit.geomID, 0xff, 32);
        std::memset(q.hit.instID, 0xff, sizeof q.hit.instID);
        rtcIntersect8(ALL_LANES, scene, &context, &q);
        for (unsigned id : q.hit.geomID) hits += id != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

static uint64_t occluded8(RTCScene scene, const Packet* packets, size_t count) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    uint64_t hits = 0;
    RTCRay8 q;
    for (size_t i = 0; i < count; ++i) {
        set_ray8(q, packets[i]);
        rtcOccluded8(ALL_LANES, scene, &context, &q);
        for (float t : q.tfar) hits += t == -std::numeric_limits<float>::infinity();
    }
    return hits;
}

template <class Item>
using Query = uint64_t (*)(RTCScene, const Item*, size_t);

// One pass over all items, shared out in chunks; returns the hits.
template <class Item>
static uint64_t pass(Query<Item> query, RTCScene scene, const std::vector<Item>& items, int threads) {
    const size_t chunk = 4096;
    std::atomic<size_t> next{0};
    std::atomic<uint64_t> hits{0};
    auto work = [&] {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
        for (size_t at; (at = next.fetch_add(chunk)) < items.size();)
            hits += query(scene, items.data() + at, std::min(chunk, items.size() - at));
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
    for (auto& other : others) other.join();
    return hits;
}

template <class Item>
static void measure(const char* name, Query<Item> query, RTCScene scene, const std::vector<Item>& items, size_t rays,
                    int threads, int repeats) {
    uint64_t hits = pass(query, scene, items, threads);
    std::vector<double> rates;
    for (int i = 0; i < repeats; ++i) {
        double start = seconds();
        if (pass(query, scene, items, threads) != hits) throw std::runtime_error("hit counts differ between passes");
        rates.push_back(double(rays) / (seconds() - start) * 1e-6);
    }
    Spread s = spread(rates);
    std::printf("%-13s threads %d  Mrays/s %7.2f  (%.2f .. %.2f)  hits %llu of %zu\n", name, threads, s.median, s.least,
                s.most, static_cast<unsigned long long>(hits), rays);
}

static void measure_rays(const Mesh& mesh, const std::vector<Vec3>& padded, const std::string& file, int threads,
                         int repeats) {
    std::vector<Ray> rays = read_rays(file);
    if (rays.empty()) throw std::runtime_error(file + " holds no rays");
    std::vector<Packet> packets = packets_of(rays);
    RTCDevice device = new_device(threads);
    RTCScene scene = build(device, mesh, padded);
    measure("rtcIntersect1", Query<Ray>(intersect1), scene, rays, rays.size(), threads, repeats);
    measure("rtcIntersect8", Query<Packet>(intersect8), scene, packets, rays.size(), threads, repeats);
    measure("rtcOccluded1", Query<Ray>(occluded1), scene, rays, rays.size(), threads, repeats);
    measure("rtcOccluded8", Query<Packet>(occluded8), scene, packets, rays.size(), threads, repeats);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

static bool add_bytes(void* total, ssize_t bytes, bool) {
    *static_cast<std::atomic<ssize_t>*>(total) += bytes;
    return true;
}

static void measure_build(const Mesh& mesh, const std::vector<Vec3>& padded, int threads, int repeats) {
    RTCDevice device = new_device(threads);
    std::atomic<ssize_t> bytes{0};
    rtcSetDeviceMemoryMonitorFunction(device, add_bytes, &bytes);
    std::vector<double> times;
    ssize_t held = 0;
    for (int i = 0; i <= repeats; ++i) {
        double start = seconds();
        RTCScene scene = build(device, mesh, padded);
        if (i > 0) times.push_back((seconds() - start) * 1e3);  // the first build also starts the threads
        held = bytes;
        rtcReleaseScene(scene);
    }
    Spread s = spread(times);
    std::printf("embree_build  threads %d  ms %9.2f  (%.2f .. %.2f)  bytes a triangle %.1f  triangles %zu\n", threads,
                s.median, s.least, s.most, double(held) / double(mesh.triangles.size()), mesh.triangles.size());
    rtcReleaseDevice(device);
}

static void make_rays(const Mesh& mesh, const std::vector<Vec3>& padded, const std::string& kind,
                      const std::string& file, const View& view) {
    RTCDevice device = new_device(1);
    RTCScene scene = build(device, mesh, padded);
    ClosestHit closest = [&](const Ray& ray) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit q;
        q.ray = ray1(ray);
        q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &q);
        return Hit{q.hit.geomID != RTC_INVALID_GEOMETRY_ID, q.ray.tfar, q.hit.u, q.hit.v, q.hit.primID};
    };
    std::vector<Ray> rays;
    if (kind == "camera") rays = camera_rays(view);
    else if (kind == "shadow") rays = shadow_rays(view, closest);
    else if (kind == "mirror") rays = mirror_rays(view, mesh, closest);
    else if (kind == "random") rays = random_rays(mesh);
    else throw std::runtime_error("unknown ray class " + kind + " (camera, shadow, mirror, random)");
    write_rays(file, rays);
    std::printf("%s: %zu %s rays\n", file.c_str(), rays.size(), kind.c_str());
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

const char* const USAGE =
    "embree_rays MESH.obj --make-rays camera|shadow|mirror|random OUT.bin [--view scene05|scene06]\n"
    "embree_rays MESH.obj --rays FILE.bin [--threads N] [--repeats N]\n"
    "embree_rays MESH.obj --build [--repeats N]\n";

static int run(std::vector<std::string> words) {
    std::string mesh_file, kind, out, rays, view = "scene06";
    bool wants_build = false;
    int threads = 1, repeats = 9;
    for (size_t i = 0; i < words.size(); ++i) {
        auto value = [&]() -> std::string {
            if (++i == words.size()) throw std::runtime_error("missing value after " + words[i - 1]);
            return words[i];
        };
        if (words[i] == "--make-rays") kind = value(), out = value();
        else if (words[i] == "--view") view = value();
        else if (words[i] == "--rays") rays = value();
        else if (words[i] == "--threads") threads = std::max(1, std::stoi(value()));
        else if (words[i] == "--repeats") repeats = std::max(1, std::stoi(value()));
        else if (words[i] == "--build") wants_build = true;
        else if (mesh_file.empty() && words[i][0] != '-') mesh_file = words[i];
        else throw std::runtime_error("unexpected " + words[i]);
    }
    if (mesh_file.empty() || (kind.empty() && rays.empty() && !wants_build)) {
        std::cerr << USAGE;
        return 2;
    }
    Mesh mesh = load_obj(mesh_file);
    std::vector<Vec3> padded = mesh.vertices;
    padded.push_back({0, 0, 0});
    if (!kind.empty()) make_rays(mesh, padded, kind, out, view_named(view));
    if (!rays.empty()) measure_rays(mesh, padded, rays, threads, repeats);
    if (wants_build)
        for (int n : {1, 2}) measure_build(mesh, padded, n, repeats);
    return 0;
}

int main(int argc, char** argv) {
    try {
        return run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        std::cerr << "embree_rays: " << error.what() << "\n";
        return 1;
    }
}
