// The tools, a file each. Internal to the tool room: stroke.h dispatches to them.
//
// validate throws InvalidInput as check.h says; flow_of and warn are for valid strokes (a stamp has no flow of its
// own); warn appends sentences.
#pragma once

#include <string>
#include <vector>

#include "knead/tool/stroke.h"

namespace knead::tool_detail {

using Warnings = std::vector<std::string>;

void validate(const ImplicitStroke& stroke);
void validate(const PaintStroke& stroke);
void validate(const PointsStroke& stroke);
void validate(const HandlesStroke& stroke);
void validate(const StampStroke& stroke);
void validate(const RotateStroke& stroke);
void validate(const StretchStroke& stroke);
void validate(const TwistStroke& stroke);
void validate(const BendStroke& stroke);

Flow flow_of(const ImplicitStroke& stroke);
Flow flow_of(const PaintStroke& stroke);
Flow flow_of(const PointsStroke& stroke);
Flow flow_of(const HandlesStroke& stroke);  // vertices have been looked up: full and zero hold the points
Flow flow_of(const RotateStroke& stroke);
Flow flow_of(const StretchStroke& stroke);
Flow flow_of(const TwistStroke& stroke);
Flow flow_of(const BendStroke& stroke);

void warn(const ImplicitStroke& stroke, Warnings& warnings);
void warn(const PaintStroke& stroke, Warnings& warnings);
void warn(const PointsStroke& stroke, Warnings& warnings);
void warn(const HandlesStroke& stroke, Warnings& warnings);
void warn(const StampStroke& stroke, Warnings& warnings);
void warn(const RotateStroke& stroke, Warnings& warnings);
void warn(const StretchStroke& stroke, Warnings& warnings);
void warn(const TwistStroke& stroke, Warnings& warnings);
void warn(const BendStroke& stroke, Warnings& warnings);

// One segment of one field that is carried along with its displacement.
Segment carried_segment(Field field, const Vec3d& displacement, TimeLaw time_law = TimeLaw::swept);

// One segment of one field that rests.
Segment resting_segment(Field field);

// Warns where a thin intermediate region makes the flow back beside the tool strong (inner / outer above 0.9).
void warn_of_thin_shell(double inner, double outer, Warnings& warnings);

// The thresholds that a bend's extent stands for.
Thresholds<double> bend_thresholds(const BendStroke& stroke);

}  // namespace knead::tool_detail
