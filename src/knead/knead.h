// Knead deforms 3D shapes along divergence-free velocity fields (von Funck, Theisel, Seidel, "Vector Field Based Shape
// Deformations", SIGGRAPH 2006). This header includes the library and is its table of contents.
//
// A stroke (what a person did with a tool) becomes a flow (segments of velocity fields); a flow moves points:
//
//   const ShapeFile shape = read_shape("in.ply");
//   std::vector<Vec3d> points = shape.mesh.positions;
//   const double size = bounding_box(points).diagonal();
//   ImplicitStroke pull;                       // a ball: points within `inner` follow the path,
//   pull.path = {points[0], points[0] + Vec3d{0, 0.1 * size, 0}};
//   pull.inner = 0.02 * size;                  // points beyond `outer` stay
//   pull.outer = 0.15 * size;
//   advect(flow_of(pull), points, {.tolerance = absolute_tolerance(kDefaultRelativeTolerance, size)});
//   write_shape("out.ply", shape, points);
//
// docs/tutorial.md goes on from here. You may include each header by itself; none needs an earlier one. The libraries
// knead::gpu (advect on a GPU, knead/gpu/gpu.h) and knead::render (pictures, knead/render/renderer.h) are optional and
// not included here.
#pragma once

// Vectors, boxes, threads, and the two exceptions that the library throws.
#include "knead/math/box.h"
#include "knead/math/error.h"
#include "knead/math/mat3.h"
#include "knead/math/parallel.h"
#include "knead/math/progress.h"
#include "knead/math/vec3.h"

// The velocity field of one tool at one point: inner motion, region and blend.
#include "knead/field/field.h"
#include "knead/field/mask.h"
#include "knead/field/motion.h"
#include "knead/field/region.h"

// Flows: values that you can invert, cut and save. advect moves points through one.
#include "knead/flow/advect.h"
#include "knead/flow/backend.h"
#include "knead/flow/point_blocks.h"
#include "knead/flow/reach.h"
#include "knead/flow/segment.h"

// Meshes, and what you can ask of them.
#include "knead/mesh/measures.h"
#include "knead/mesh/mesh.h"
#include "knead/mesh/normals.h"
#include "knead/mesh/self_intersections.h"
#include "knead/mesh/shapes.h"
#include "knead/mesh/surface_tree.h"
#include "knead/mesh/triangulate.h"

// Files: read a shape, and write it back with everything else that its file holds.
#include "knead/io/animation.h"
#include "knead/io/atomic_file.h"
#include "knead/io/remeshed.h"
#include "knead/io/shape_file.h"

// Refines a mesh where a flow stretches it.
#include "knead/remesh/remesh.h"

// Strokes: one plain struct per tool, and the flow that each becomes.
#include "knead/tool/paint.h"
#include "knead/tool/placement.h"
#include "knead/tool/strain.h"
#include "knead/tool/stroke.h"
#include "knead/tool/tool.h"

// Fits one shape to another by strokes that strain it least.
#include "knead/fit/fit.h"

// Sessions: the .knead file, replay, the certificate, and the workbench of an interactive program.
#include "knead/session/deformed_shape.h"
#include "knead/session/journal.h"
#include "knead/session/replay.h"
#include "knead/session/report.h"
#include "knead/session/safe_until.h"
#include "knead/session/session.h"
#include "knead/session/workbench.h"
