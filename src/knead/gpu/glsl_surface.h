// The source text of the compute shaders that ask about a surface. Internal to the gpu room.
#pragma once

#include <cstddef>
#include <string>

namespace knead::gpu {

inline constexpr std::size_t kSurfaceRanges = 4;             // of points, which are bound to the places from 0 on
inline constexpr std::size_t kTrianglesPlace = 4;            // where the triangles are bound
inline constexpr std::size_t kResultPlace = 5;               // and what is found
inline constexpr std::size_t kTrianglesToAWorkGroup = 1024;  // of 64 threads

// A sum for each work group, from first_group on in the result.
std::string volume_source();

// The sum of `count` numbers at place 0, in the result.
std::string sum_source();

// The triangles that a ray may meet.
std::string candidates_source();

}  // namespace knead::gpu
