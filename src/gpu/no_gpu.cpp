// The backend for systems whose OpenGL has no compute shaders: constructors throw.
#include "knead/editor/gpu.h"

namespace knead::gpu {

namespace {

[[noreturn]] void fail() { throw GpuError("this build cannot deform on a GPU; use the CPU"); }

}  // namespace

struct GpuPoints::State {};
struct Gpu::State {};
struct GpuSurface::State {};

Gpu::Gpu(const GpuOptions&) { fail(); }
Gpu::~Gpu() = default;
const std::string& Gpu::description() const { fail(); }
bool Gpu::is_software() const { fail(); }
Transfers Gpu::transfers() const { fail(); }
GpuPoints Gpu::upload(std::span<const Vec3d>) { fail(); }
void Gpu::download(const GpuPoints&, std::span<Vec3d>) { fail(); }
void Gpu::enqueue(const Flow&, GpuPoints&, const AdvectOptions&) { fail(); }
AdvectResult Gpu::collect(GpuPoints&) { fail(); }
void Gpu::write(GpuPoints&, std::size_t, std::span<const Vec3d>) { fail(); }
void Gpu::assign(GpuPoints&, const GpuPoints&) const { fail(); }
std::vector<GpuBuffer> Gpu::buffers(const GpuPoints&) { fail(); }

GpuPoints::~GpuPoints() = default;
GpuPoints::GpuPoints(GpuPoints&&) noexcept = default;
GpuPoints& GpuPoints::operator=(GpuPoints&&) noexcept = default;
std::size_t GpuPoints::size() const { fail(); }

GpuSurface::GpuSurface(Gpu&, std::span<const std::array<std::uint32_t, 3>>) { fail(); }
GpuSurface::~GpuSurface() = default;
GpuSurface::GpuSurface(GpuSurface&&) noexcept = default;
GpuSurface& GpuSurface::operator=(GpuSurface&&) noexcept = default;
double GpuSurface::volume(const GpuPoints&, const Vec3d&) const { fail(); }
std::optional<GpuHit> GpuSurface::first_hit(const GpuPoints&, const Vec3d&, const Vec3d&) const { fail(); }

}  // namespace knead::gpu
