// The memory of the states that are kept for undo: what several states share counts once.
#include <utility>
#include <vector>

#include "history/history.h"
#include "knead/mesh.h"

namespace knead::detail {

namespace {

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

std::size_t bytes_of(const Mesh& mesh) {
  std::size_t bytes = bytes_of(mesh.positions) + bytes_of(mesh.face_begin) + bytes_of(mesh.corner_vertex);
  for (const Attribute& attribute : mesh.attributes) bytes += bytes_of(attribute.values);
  return bytes;
}

std::size_t bytes_of(const Provenance& provenance) {
  std::size_t bytes = bytes_of(provenance.face_source) + bytes_of(provenance.vertex_source);
  bytes += provenance.touched.capacity() / 8;
  if (provenance.creases) bytes += bytes_of(*provenance.creases);
  return bytes;
}

}  // namespace

MemoryAccount::MemoryAccount(const ShapeState& base) {
  count(base, true);
  std::exchange(bytes_, 0);
}

void MemoryAccount::add(const ShapeState& state) {
  count(state, true);
  ++states_;
}

void MemoryAccount::remove(const ShapeState& state) {
  count(state, false);
  --states_;
}

void MemoryAccount::count(const void* part, std::size_t bytes, bool is_added) {
  if (part == nullptr) return;
  if (is_added) {
    if (++uses_[part] == 1) bytes_ += bytes;
  } else if (const auto use = uses_.find(part); --use->second == 0) {
    uses_.erase(use);
    bytes_ -= bytes;
  }
}

void MemoryAccount::count(const ShapeState& state, bool is_added) {
  state.positions.for_each_chunk([&](const void* chunk, std::size_t bytes) { count(chunk, bytes, is_added); });
  if (state.mesh) count(state.mesh.get(), bytes_of(*state.mesh), is_added);
  if (state.provenance) count(state.provenance.get(), bytes_of(*state.provenance), is_added);
  count(state.splats.get(), state.splat_bytes(), is_added);
  const std::size_t own = sizeof(ShapeState) + state.positions.table_bytes() + bytes_of(state.normals);
  bytes_ = is_added ? bytes_ + own : bytes_ - own;
}

KeptState::KeptState(ShapeState state, std::shared_ptr<MemoryAccount> account)
    : state_(std::move(state)), account_(std::move(account)) {
  account_->add(state_);
}

KeptState::~KeptState() { account_->remove(state_); }

}  // namespace knead::detail
