// Owners of OpenGL names, and what is done with them. Internal to the gpu room; the context must be current.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <string>
#include <utility>

namespace knead::gpu {

// Move-only owner of one name.
template <void (*kDelete)(GLuint)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(GLuint name) : name_(name) {}
  ~GlName() {
    if (name_ != 0) kDelete(name_);
  }
  GlName(const GlName&) = delete;
  GlName& operator=(const GlName&) = delete;
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }

  GLuint get() const { return name_; }
  // Of a lost context: there may be another one now, in which the name means something else.
  void forget() { name_ = 0; }

 private:
  GLuint name_ = 0;
};

void delete_buffer(GLuint name);
void delete_program(GLuint name);
using Buffer = GlName<delete_buffer>;
using Program = GlName<delete_program>;

// A buffer with these bytes, or room for them where data is null. Throws GpuError where the memory does not suffice.
Buffer make_buffer(const void* data, std::size_t bytes);

void read_buffer(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, void* to);
void write_buffer(const Buffer& buffer, std::size_t first_byte, std::size_t bytes, const void* from);
void copy_buffer(const Buffer& from, const Buffer& to, std::size_t bytes);

// Sets all words of the buffer to 0.
void clear_words(const Buffer& buffer);

// Throws GpuError with the driver's first words where the source does not compile.
Program make_compute_program(const std::string& source);

// Throws GpuError if anything went wrong since it was last asked, or the GPU was lost.
void require_no_error();

}  // namespace knead::gpu
