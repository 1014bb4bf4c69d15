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
// knead::gpu (advect on a GPU, knead/editor/gpu.h) and knead::render (pictures, knead/editor/render.h) are optional and
// not included here.
#pragma once

// The version of the library whose headers these are, MAJOR.MINOR.PATCH; each number is at most 99.

// For messages.
#define KNEAD_VERSION "0.10.0"

// For `#if`: 10000 MAJOR + 100 MINOR + PATCH.
#define KNEAD_VERSION_NUMBER 1000

// Vectors, matrices and boxes; the exceptions that the library throws, progress and threads.
#include "knead/error.h"
#include "knead/vec.h"

// The velocity field of one tool at one point: inner motion, region and blend.
#include "knead/field.h"
#include "knead/region.h"

// Flows: values that you can invert, cut and save. advect moves points through one.
#include "knead/flow.h"

// Meshes, Gaussian splats and volume meshes, and their measures.
#include "knead/cells.h"
#include "knead/mesh.h"

// Files: read a shape, and write it back with everything else that its file holds; animations.
#include "knead/io.h"

// Refines a mesh where a flow stretches it.
#include "knead/remesh.h"

// Fits one shape to another by strokes that strain it least; poses a shape by its skeleton.
#include "knead/fit.h"

// Strokes: one plain struct per tool, and the flow that each becomes; what tools want of a surface.
#include "knead/editor/tools.h"
#include "knead/stroke.h"

// Sessions: the .knead file, replay, derivatives, report and certificate.
#include "knead/certify.h"
#include "knead/replay.h"
#include "knead/session.h"

// Editors: a shape that strokes deform and its states, and the workbench with undo.
#include "knead/editor/shape_state.h"
#include "knead/editor/workbench.h"
