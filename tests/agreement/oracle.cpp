#include "agreement/oracle.h"

#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "support/pins_now.h"

namespace knead::oracle {

namespace {

using Json = nlohmann::json;
using State = std::array<double, 3>;

Vec3d vec(const Json& j) { return {j[0], j[1], j[2]}; }
std::vector<Vec3d> vecs(const Json& j) {
  std::vector<Vec3d> result;
  for (const Json& item : j) result.push_back(vec(item));
  return result;
}

struct Scalar {  // a value and its gradient
  double value = 0;
  Vec3d gradient;
};

// One field: r and the motion as functions of d = x - c and of time.
struct OracleField {
  Vec3d center;
  double inner = 0;
  double outer = 1;
  std::function<Scalar(const Vec3d& d, double t)> r;
  // v where r < inner, and A; e, f where the paper gives them.
  std::function<Vec3d(const Vec3d& d)> u;
  std::function<Vec3d(const Vec3d& d)> potential;
  int falloff = 4;
  double bump = 0;  // not 0: wide
};

struct OracleSegment {
  std::vector<OracleField> fields;
  Vec3d displacement;
  bool blended = false;
  double longest_step = 0.01;
  std::function<bool(const Vec3d& x)> member = [](const Vec3d&) { return true; };
  std::function<Vec3d(const Vec3d& x, double t)> velocity{};  // in the place of the fields' sum
};

// 1 - b, b the Bernstein polynomial of the degree whose first three coefficients are 0 and whose others are 1.
double complement(int degree, double s) {
  const double q = 1 - s;
  return std::pow(q, degree) + degree * s * std::pow(q, degree - 1) +
         0.5 * degree * (degree - 1) * s * s * std::pow(q, degree - 2);
}
double complement_slope(int degree, double s) {
  return -0.5 * degree * (degree - 1) * (degree - 2) * s * s * std::pow(1 - s, degree - 3);
}

// w of the wide falloff from its definition, and its slope by r.
std::array<double, 2> wide(const OracleField& f, double r) {
  const double a2 = f.bump * f.bump;
  const double o2 = f.outer * f.outer;
  const double in = std::max(1 - r * r / a2, 0.0);
  const double out = std::max(1 - r * r / o2, 0.0);
  const double scale = a2 * o2 / (3 * (o2 - a2));
  const double r2 = r * r;
  if (r < 1e-4 * f.bump) return {1 - r2 * (1 / a2 + 1 / o2), -2 * r * (1 / a2 + 1 / o2)};
  const double difference = std::pow(out, 3) - std::pow(in, 3);
  return {difference * scale / r2, scale * (6 * (in * in / a2 - out * out / o2) / r - 2 * difference / (r2 * r))};
}

// curl(w A), w = (1 - b)^2, or its third power for the degree 3, by the product rule.
Vec3d field_velocity(const OracleField& f, const Vec3d& d, double t) {
  const Scalar r = f.r(d, t);
  if (f.bump > 0) {
    const auto [w, w_slope] = wide(f, r.value);
    return f.u(d) * w + cross(r.gradient * w_slope, f.potential(d));
  }
  const double s = (r.value - f.inner) / (f.outer - f.inner);
  if (s >= 1) return {0, 0, 0};
  if (s <= 0) return f.u(d);
  const int power = f.falloff == 3 ? 3 : 2;
  const double c = complement(f.falloff, s);
  const double slope = power * std::pow(c, power - 1) * complement_slope(f.falloff, s);
  return f.u(d) * std::pow(c, power) + cross(r.gradient * (slope / (f.outer - f.inner)), f.potential(d));
}

Vec3d segment_velocity(const OracleSegment& segment, const Vec3d& x, double t) {
  if (segment.velocity) return segment.velocity(x, t);
  Vec3d sum{0, 0, 0};
  for (const OracleField& f : segment.fields) {
    const Vec3d d = x - f.center;
    if (segment.blended) {
      sum += field_velocity(f, d, t) * (1 - t) + field_velocity(f, d - segment.displacement, t) * t;
    } else {
      sum += field_velocity(f, d - segment.displacement * t, t);
    }
  }
  return sum;
}

Vec3d integrate(const OracleSegment& segment, const Vec3d& x, double size) {
  namespace odeint = boost::numeric::odeint;
  State state{x.x, x.y, x.z};
  const auto stepper =
      odeint::make_controlled(1e-14 * size, 0.0, segment.longest_step, odeint::runge_kutta_dopri5<State>());
  const auto rate = [&](const State& y, State& dydt, double t) {
    const Vec3d v = segment_velocity(segment, {y[0], y[1], y[2]}, t);
    dydt = {v.x, v.y, v.z};
  };
  odeint::integrate_adaptive(stepper, rate, state, 0.0, 1.0, segment.longest_step);
  return {state[0], state[1], state[2]};
}

// --- inner motions -------------------------------------------------------------------------------------------------

// A_1 = (e grad f - f grad e)/2 and u = grad e x grad f.
void set_from_e_and_f(OracleField& field, const std::function<Scalar(const Vec3d&)>& e,
                      const std::function<Scalar(const Vec3d&)>& f, double gauge,
                      const std::function<Vec3d(const Vec3d&)>& a0) {
  field.u = [=](const Vec3d& d) { return cross(e(d).gradient, f(d).gradient); };
  field.potential = [=](const Vec3d& d) {
    const Scalar se = e(d);
    const Scalar sf = f(d);
    const Vec3d a1 = (sf.gradient * se.value - se.gradient * sf.value) * 0.5;
    return gauge == 1 ? a1 : a1 * gauge + a0(d) * (1 - gauge);
  };
}

void set_translation(OracleField& field, const Vec3d& v0, double gauge = 1, const Vec3d& axis = {}) {
  const Vec3d other = std::abs(v0.x) > std::abs(v0.y) ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  const Vec3d p = normalized(cross(v0, other));
  const Vec3d q = cross(v0, p);
  const Vec3d parallel = axis * dot(axis, v0);
  const Vec3d turned = cross(axis, v0 - parallel);
  set_from_e_and_f(
      field,
      [=](const Vec3d& d) {
        return Scalar{dot(p, d), p};
      },
      [=](const Vec3d& d) {
        return Scalar{dot(q, d), q};
      },
      gauge, [=](const Vec3d& d) { return cross(parallel, d) * 0.5 + axis * dot(turned, d); });
}

std::function<Scalar(const Vec3d&)> axis_distance2(const Vec3d& a, double factor) {
  return [=](const Vec3d& d) {
    const Vec3d across = d - a * dot(a, d);
    return Scalar{factor * norm2(across), across * (2 * factor)};
  };
}

void set_rotation(OracleField& field, const Vec3d& a, double angle, double gauge, bool ball) {
  const auto e = [=](const Vec3d& d) { return Scalar{dot(a, d), a}; };
  set_from_e_and_f(field, e, axis_distance2(a, angle / 2), gauge, [=](const Vec3d& d) {
    const Vec3d across = d - a * dot(a, d);
    return ball ? d * (angle * dot(a, d)) : a * (-angle / 2 * norm2(across));
  });
}

void set_twist(OracleField& field, const Vec3d& a, double rate, double gauge) {
  const auto e = [=](const Vec3d& d) {
    const double h = dot(a, d);
    return Scalar{rate / 4 * h * h, a * (rate / 2 * h)};
  };
  set_from_e_and_f(field, e, axis_distance2(a, 1), gauge, [=](const Vec3d& d) {
    const Vec3d across = d - a * dot(a, d);
    return a * (-rate / 2 * dot(a, d) * norm2(across));
  });
}

// --- regions ---------------------------------------------------------------------------------------------------------

Scalar distance_from(const Vec3d& d) {
  const double length = norm(d);
  return {length, length > 0 ? d / length : Vec3d{}};
}

std::function<Scalar(const Vec3d&, double)> ball() {
  return [](const Vec3d& d, double) { return distance_from(d); };
}

std::function<Scalar(const Vec3d&, double)> capsule(const Vec3d& h) {
  return [=](const Vec3d& d, double) {
    return distance_from(d - h * std::fmin(1.0, std::fmax(-1.0, dot(h, d) / norm2(h))));
  };
}

Vec3d turned(const Vec3d& v, const Vec3d& a, double angle) {
  return v * std::cos(angle) + cross(a, v) * std::sin(angle) + a * (dot(a, v) * (1 - std::cos(angle)));
}

std::function<Scalar(const Vec3d&, double)> half_space(const Vec3d& n, const Vec3d& a, double turn) {
  return [=](const Vec3d& d, double t) {
    const Vec3d now = turned(n, a, turn * t);
    return Scalar{dot(now, d), now};
  };
}

// r_k^-4 = 3/4 integral |x - y|^-5 dl by Gauss-Legendre quadrature on pieces no longer than half their distance.
Scalar curve_distance(const std::vector<Vec3d>& curve, const Vec3d& d) {
  static const std::array<double, 4> node = {0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                                             0.96028985649753623168};
  static const std::array<double, 4> weight = {0.36268378337836198297, 0.31370664587788728734, 0.22238103445337447054,
                                               0.10122853629037625915};
  double integral = 0;
  Vec3d gradient{0, 0, 0};
  bool touches = false;
  const std::function<void(const Vec3d&, const Vec3d&)> add = [&](const Vec3d& a, const Vec3d& b) {
    const Vec3d e = b - a;
    const double along = std::fmin(1.0, std::fmax(0.0, dot(e, d - a) / norm2(e)));
    const double distance = norm(d - a - e * along);
    touches = touches || distance < 1e-12;
    if (!touches && norm(e) > 0.5 * distance) {
      const Vec3d middle = (a + b) * 0.5;
      add(a, middle);
      add(middle, b);
      return;
    }
    for (std::size_t i = 0; i < node.size(); ++i) {
      for (const double sign : {-1.0, 1.0}) {
        const Vec3d from = d - (a + e * (0.5 + 0.5 * sign * node[i]));
        const double dl = 0.5 * weight[i] * norm(e);
        integral += dl * std::pow(norm(from), -5);
        gradient += from * (-5 * dl * std::pow(norm(from), -7));
      }
    }
  };
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) add(curve[i], curve[i + 1]);
  if (touches) return {};
  const double r = std::pow(0.75 * integral, -0.25);
  return {r, gradient * (-0.25 * r / integral)};
}

std::function<Scalar(const Vec3d&, double)> point_set(const std::vector<Vec3d>& points,
                                                      const std::vector<std::vector<Vec3d>>& curves, int m) {
  return [=](const Vec3d& d, double) {
    std::vector<Scalar> parts;
    for (const Vec3d& p : points) parts.push_back(distance_from(d - p));
    for (const auto& curve : curves) parts.push_back(curve_distance(curve, d));
    double sum = 0;
    for (const Scalar& part : parts) {
      if (part.value == 0) return Scalar{};
      sum += std::pow(part.value, -m);
    }
    const double r = std::pow(sum, -1.0 / m);
    Vec3d gradient{0, 0, 0};
    for (const Scalar& part : parts) gradient += part.gradient * std::pow(r / part.value, m + 1);
    return Scalar{r, gradient};
  };
}

// --- strokes ---------------------------------------------------------------------------------------------------------

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

OracleSegment sweep(OracleField field, const Vec3d& by) {
  OracleSegment segment;
  segment.displacement = by;
  segment.longest_step = std::fmin(0.01, 0.02 * (field.outer - field.inner) / norm(by));
  segment.fields.push_back(std::move(field));
  return segment;
}

std::vector<OracleSegment> implicit(const Json& j) {
  std::vector<OracleSegment> result;
  const auto path = vecs(j["path"]);
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec3d by = path[i + 1] - path[i];
    if (by == Vec3d{0, 0, 0}) continue;
    const double bump = j.value("bump", 0.0);
    OracleField field{path[i], j.value("inner", 0.0), j.value("outer", 4 * bump), ball(), {}, {}, 4, bump};
    if (j.value("region", "ball") == "capsule") {
      const Vec3d h = vec(j["half_axis"]);
      field.r = capsule(h);
      set_translation(field, by, j.value("gauge", 0.0), normalized(h));
    } else {
      set_translation(field, by);
    }
    result.push_back(sweep(field, by));
    result.back().blended = j.value("time", "swept") == "blended";
  }
  return result;
}

std::vector<OracleSegment> paint(const Json& j) {
  std::vector<OracleSegment> result;
  for (const Json& sample : j["samples"]) {
    const Vec3d by = normalized(vec(sample["normal"])) * -j["depth"].get<double>();
    const double bump = j.value("bump", 0.0);
    OracleField field{vec(sample["point"]), 0, j.value("outer", 4 * bump), ball(), {}, {}, 4, bump};
    set_translation(field, by);
    result.push_back(sweep(field, by));
  }
  return result;
}

// Parts by repeated merging; every point or polyline is one element. Distances between polylines by sampling finely.
struct Element {
  std::vector<Vec3d> points;  // one, or a polyline
};

double element_distance(const Element& a, const Element& b) {
  const auto dense = [](const Element& e) {
    if (e.points.size() == 1) return e.points;
    std::vector<Vec3d> result;
    for (std::size_t i = 0; i + 1 < e.points.size(); ++i) {
      for (int k = 0; k <= 50; ++k) result.push_back(e.points[i] + (e.points[i + 1] - e.points[i]) * (k / 50.0));
    }
    return result;
  };
  double least = 1e300;
  for (const Vec3d& p : dense(a)) {
    for (const Vec3d& q : dense(b)) least = std::fmin(least, norm(p - q));
  }
  return least;
}

std::vector<std::vector<Element>> parts_of(const std::vector<Element>& elements, double outer) {
  std::vector<std::size_t> part(elements.size());
  for (std::size_t i = 0; i < part.size(); ++i) part[i] = i;
  for (std::size_t i = 0; i < part.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (element_distance(elements[i], elements[k]) >= outer) continue;
      const std::size_t from = part[i];
      for (std::size_t& p : part) p = p == from ? part[k] : p;
    }
  }
  std::vector<std::vector<Element>> result;
  for (std::size_t label = 0; label < part.size(); ++label) {
    std::vector<Element> members;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (part[i] == label) members.push_back(elements[i]);
    }
    if (!members.empty()) result.push_back(members);
  }
  return result;
}

Vec3d barycentre(const std::vector<Element>& part, double outer) {
  Vec3d sum{0, 0, 0};
  double total = 0;
  for (const Element& e : part) {
    if (e.points.size() == 1) {
      sum += e.points[0];
      total += 1;
    }
    for (std::size_t i = 0; i + 1 < e.points.size(); ++i) {
      const double weight = norm(e.points[i + 1] - e.points[i]) / outer;
      sum += (e.points[i] + e.points[i + 1]) * (0.5 * weight);
      total += weight;
    }
  }
  return sum / total;
}

std::vector<OracleSegment> points(const Json& j) {
  std::vector<Element> elements;
  for (const Vec3d& p : vecs(j.value("points", Json::array()))) elements.push_back({{p}});
  for (const Json& curve : j.value("curves", Json::array())) elements.push_back({vecs(curve)});
  const double outer = j["outer"];
  const bool one = j.value("center", "parts") == "barycentre";
  const auto parts = one ? std::vector<std::vector<Element>>{elements} : parts_of(elements, outer);
  std::vector<OracleSegment> result;
  Vec3d moved{0, 0, 0};
  for (const Vec3d& by : vecs(j["displacements"])) {
    OracleSegment segment;
    for (const auto& part : parts) {
      const Vec3d c = barycentre(part, outer);
      std::vector<Vec3d> isolated;
      std::vector<std::vector<Vec3d>> curves;
      for (const Element& e : part) {
        std::vector<Vec3d> relative;
        for (const Vec3d& p : e.points) relative.push_back(p - c);
        if (relative.size() == 1)
          isolated.push_back(relative[0]);
        else
          curves.push_back(relative);
      }
      OracleField field{
          c + moved, j.value("inner", 0.0), outer, point_set(isolated, curves, j.value("exponent", 8)), {}, {}};
      set_translation(field, by);
      const OracleSegment single = sweep(field, by);
      segment.displacement = single.displacement;
      segment.longest_step = single.longest_step;
      segment.fields.push_back(single.fields[0]);
    }
    result.push_back(segment);
    moved += by;
  }
  return result;
}

// r = F / (F + Z): F the distance from the full set as it then is, Z from the zero set.
OracleSegment handles(const Json& j) {
  const Json& motion = j["motion"];
  const bool turns = motion.contains("rotate");
  const auto full = vecs(j["full"]);
  const auto zero = vecs(j["zero"]);
  Vec3d c{0, 0, 0};
  for (const Vec3d& p : full) c += p / static_cast<double>(full.size());
  if (turns) c = vec(motion["center"]);
  const Vec3d a = turns ? normalized(vec(motion["rotate"])) : Vec3d{0, 0, 1};
  const double angle = turns ? radians(motion["angle_deg"]) : 0;
  const Vec3d by = turns ? Vec3d{0, 0, 0} : vec(motion["translate"]);
  OracleField field{c, 0, 1, {}, {}, {}};
  field.r = [=, m = j.value("exponent", 8)](const Vec3d& d, double t) {
    std::vector<Vec3d> now;
    for (const Vec3d& p : full) now.push_back(turned(p - c, a, angle * t));
    std::vector<Vec3d> rests;
    for (const Vec3d& p : zero) rests.push_back(p - c - by * t);
    const Scalar f = point_set(now, {}, m)(d, t);
    const Scalar z = point_set(rests, {}, m)(d, t);
    const double sum = f.value + z.value;
    return Scalar{f.value / sum, f.gradient / sum - (f.gradient + z.gradient) * (f.value / (sum * sum))};
  };
  turns ? set_rotation(field, a, angle, 1, false) : set_translation(field, by);
  return {{field}, by};
}

OracleSegment rotate(const Json& j) {
  OracleField field{vec(j["center"]), j["inner"], j["outer"], ball(), {}, {}};
  set_rotation(field, normalized(vec(j["axis"])), radians(j["angle_deg"]), j.value("gauge", 0.0), true);
  return {{field}, {0, 0, 0}};
}

OracleSegment stretch(const Json& j) {
  OracleField field{vec(j["center"]), j["inner"], j["outer"], ball(), {}, {}};
  const Vec3d a = normalized(vec(j["axis"]));
  const double rate = std::log(j["factor"].get<double>());
  field.u = [=](const Vec3d& d) { return (a * dot(a, d) - (d - a * dot(a, d)) * 0.5) * rate; };
  field.potential = [u = field.u](const Vec3d& d) { return cross(u(d), d) / 3.0; };
  return {{field}, {0, 0, 0}};
}

void restrict_to_cylinder(OracleSegment& segment, const Json& j, const Vec3d& c, const Vec3d& n) {
  if (!j.contains("radius")) return;
  segment.member = [c, n, radius = j["radius"].get<double>()](const Vec3d& x) {
    return norm(cross(n, x - c)) <= radius;
  };
}

OracleSegment twist(const Json& j) {
  const Vec3d a = normalized(vec(j["axis"]));
  const Vec3d n = j.contains("normal") ? normalized(vec(j["normal"])) : a;
  OracleField field{vec(j["center"]), j["inner"], j["outer"], half_space(n, a, 0), {}, {}};
  set_twist(field, a, radians(j["rate_deg"]), j.value("gauge", 0.0));
  OracleSegment segment{{field}, {0, 0, 0}};
  restrict_to_cylinder(segment, j, field.center, n);
  return segment;
}

OracleSegment bend(const Json& j) {
  const Vec3d a = normalized(vec(j["axis"]));
  const Vec3d n = normalized(vec(j["normal"]));
  const double angle = radians(j["angle_deg"]);
  const double fraction = j.value("center_fraction", 0.4867502159528536);
  const double inner = j.contains("width") ? -fraction * j["width"].get<double>() : j["inner"].get<double>();
  const double outer = j.contains("width") ? inner + j["width"].get<double>() : j["outer"].get<double>();
  OracleField field{vec(j["center"]), inner, outer, half_space(n, a, angle / 2), {}, {}};
  set_rotation(field, a, angle, j.value("gauge", 1.0), false);
  OracleSegment segment{{field}, {0, 0, 0}};
  restrict_to_cylinder(segment, j, field.center, n);
  return segment;
}

OracleSegment pins(const Json& j) {
  const auto from = vecs(j["points"]);
  std::vector<Vec3d> by = vecs(j["to"]);
  for (std::size_t i = 0; i < by.size(); ++i) by[i] = by[i] - from[i];
  OracleSegment segment;
  segment.longest_step = 0.05;
  segment.velocity = [=, radius = j["radius"].get<double>()](const Vec3d& x, double t) {
    const PinsNow pins(from, by, radius, t);
    return pins.velocity(x);
  };
  return segment;
}

std::vector<OracleSegment> segments_of(const Json& j) {
  const std::string tool = j["tool"];
  if (tool == "implicit") return implicit(j);
  if (tool == "paint") return paint(j);
  if (tool == "points") return points(j);
  if (tool == "handles") return {handles(j)};
  if (tool == "rotate") return {rotate(j)};
  if (tool == "stretch") return {stretch(j)};
  if (tool == "twist") return {twist(j)};
  if (tool == "bend") return {bend(j)};
  if (tool == "pins") return {pins(j)};
  throw std::invalid_argument("the oracle does not know " + tool);
}

}  // namespace

std::vector<Vec3d> deform(const std::vector<std::string>& stroke_lines, std::vector<Vec3d> points, double size) {
  for (const std::string& line : stroke_lines) {
    const Json stroke = Json::parse(line);
    for (OracleSegment& segment : segments_of(stroke)) {
      for (OracleField& field : segment.fields) {
        if (field.bump == 0) field.falloff = stroke.value("falloff", 4);
      }
      for (Vec3d& x : points) {
        if (segment.member(x)) x = integrate(segment, x, size);
      }
    }
  }
  return points;
}

}  // namespace knead::oracle
