// Builds the coarse body of a shape, poses it as rigidly as possible, and finds the paths between its poses.
#include "fit/coarse_body.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <tuple>

#include "knead/mesh.h"
#include "knead/vec.h"
#include "mesh/body_points.h"

namespace knead::detail {

namespace {

constexpr double kWeakEdge = 0.05;          // weight of an edge between separate pieces
constexpr double kAnchorWeight = 30;        // relative to the edges of a mean node
constexpr std::size_t kApproachSteps = 10;  // in which the anchors move to their targets
constexpr std::size_t kStepRounds = 6;
constexpr std::size_t kLastRounds = 80;
constexpr std::size_t kNeighbors = 8;  // in a cloud
constexpr double kDoubtFactor = 2.5;   // times the median distance: a doubtful anchor there has a quarter of its weight

// Solves for the three coordinates, one after the other.
std::vector<Vec3d> solve(const SparseCholesky& factor, const std::vector<Vec3d>& right) {
  std::vector<Vec3d> result(right.size());
  std::vector<double> b(right.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = right[i][axis];
    factor.solve(b);
    for (std::size_t i = 0; i < b.size(); ++i) result[i][axis] = b[i];
  }
  return result;
}

// Returns the nodes that are connected with a node, the nearest along the graph first.
template <class Edges>
std::vector<std::uint32_t> breadth_first(const Edges& edges, std::uint32_t from) {
  std::vector<std::uint32_t> list{from};
  std::vector<bool> reached(edges.size(), false);
  reached[from] = true;
  for (std::size_t k = 0; k < list.size(); ++k) {
    for (const auto& edge : edges[list[k]]) {
      if (reached[edge.to]) continue;
      reached[edge.to] = true;
      list.push_back(edge.to);
    }
  }
  return list;
}

}  // namespace

std::vector<std::uint32_t> nearest_along_edges(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                               const std::vector<std::uint32_t>& chosen) {
  std::vector<std::vector<std::uint32_t>> neighbors(positions.size());
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      neighbors[t[i]].push_back(t[(i + 1) % 3]);
      neighbors[t[(i + 1) % 3]].push_back(t[i]);
    }
  }
  std::vector<double> distance(positions.size(), kInfinity);
  std::vector<std::uint32_t> nearest(positions.size(), std::numeric_limits<std::uint32_t>::max());
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::uint32_t k = 0; k < chosen.size(); ++k) {
    nearest[chosen[k]] = k;
    queue.emplace(distance[chosen[k]] = 0, chosen[k]);
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (const std::uint32_t w : neighbors[v]) {
      const double through = d + norm(positions[w] - positions[v]);
      if (!(through < distance[w])) continue;
      nearest[w] = nearest[v];
      queue.emplace(distance[w] = through, w);
    }
  }
  return nearest;
}

CoarseBody::CoarseBody(std::span<const Vec3d> positions, std::span<const Triangle> triangles, std::size_t count) {
  std::vector<std::uint32_t> vertices;
  if (triangles.empty()) {
    vertices.resize(positions.size());
    std::iota(vertices.begin(), vertices.end(), 0U);
  } else {
    for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  }
  std::vector<Vec3d> points;
  points.reserve(vertices.size());
  for (const std::uint32_t v : vertices) points.push_back(positions[v]);
  std::vector<std::uint32_t> chosen = spread_points(points, count);
  for (std::uint32_t& v : chosen) v = vertices[v];
  for (const std::uint32_t v : chosen) rest_.push_back(positions[v]);
  edges_.resize(rest_.size());
  if (triangles.empty()) {
    connect_nearest(kNeighbors);
  } else {
    connect_along_surface(positions, triangles, chosen);
  }
  connect_pieces();
  order();
  posed_ = rest_;
  turns_.resize(rest_.size());
  double sum = 0;
  for (const std::vector<Edge>& edges : edges_) {
    for (const Edge& edge : edges) sum += edge.weight;
  }
  unit_ = kAnchorWeight * std::max(sum, 1.0) / static_cast<double>(rest_.size());
}

void CoarseBody::add_edge(std::uint32_t a, std::uint32_t b, double weight) {
  if (a == b) return;
  const auto is_there = [&](const Edge& edge) { return edge.to == b; };
  if (std::any_of(edges_[a].begin(), edges_[a].end(), is_there)) return;
  edges_[a].push_back({b, weight});
  edges_[b].push_back({a, weight});
}

void CoarseBody::connect_along_surface(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                       const std::vector<std::uint32_t>& chosen) {
  const std::vector<std::uint32_t> node_of = nearest_along_edges(positions, triangles, chosen);
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = node_of[t[i]];
      const std::uint32_t b = node_of[t[(i + 1) % 3]];
      if (std::max(a, b) < rest_.size()) add_edge(a, b, 1);
    }
  }
  connect_through(positions, triangles, chosen, node_of);
}

void CoarseBody::connect_through(std::span<const Vec3d> positions, std::span<const Triangle> triangles,
                                 const std::vector<std::uint32_t>& chosen, const std::vector<std::uint32_t>& node_of) {
  const std::vector<Vec3d> normals = area_weighted_normals(positions, triangles);
  const SurfaceTree tree(triangles, positions);
  double volume = 0;
  const Vec3d& origin = positions[triangles[0][0]];
  for (const Triangle& t : triangles) {
    volume += dot(positions[t[0]] - origin, cross(positions[t[1]] - origin, positions[t[2]] - origin));
  }
  const double inward = volume < 0 ? 1 : -1;
  for (std::uint32_t k = 0; k < chosen.size(); ++k) {
    const Vec3d& n = normals[chosen[k]];
    if (!(norm(n) > 0)) continue;
    const Vec3d direction = normalized(n) * inward;
    for (const RayHit& hit : tree.hits(positions[chosen[k]], direction)) {
      const Triangle& t = triangles[hit.triangle];
      const bool is_own = t[0] == chosen[k] || t[1] == chosen[k] || t[2] == chosen[k];
      if (is_own || !(hit.t > 0)) continue;
      const bool leaves = hit.leaves == (inward < 0);
      const std::uint32_t other = node_of[t[0]];
      if (leaves && other < rest_.size()) add_edge(k, other, 1);
      break;
    }
  }
}

void CoarseBody::connect_nearest(std::size_t count) {
  for (std::uint32_t i = 0; i < rest_.size(); ++i) {
    std::vector<std::pair<double, std::uint32_t>> others;
    for (std::uint32_t k = 0; k < rest_.size(); ++k) {
      if (k != i) others.emplace_back(norm2(rest_[k] - rest_[i]), k);
    }
    const std::size_t some = std::min(count, others.size());
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(some), others.end());
    for (std::size_t k = 0; k < some; ++k) add_edge(i, others[k].second, 1);
  }
}

// Connects each piece by edges to the nodes nearest to it.
void CoarseBody::connect_pieces() {
  constexpr std::size_t kMaxTies = 4;
  while (true) {
    const std::vector<std::uint32_t> list = breadth_first(edges_, 0);
    if (list.size() == rest_.size()) return;
    std::vector<bool> reached(rest_.size(), false);
    for (const std::uint32_t node : list) reached[node] = true;
    std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> ties;
    for (const std::uint32_t a : list) {
      std::pair<double, std::uint32_t> nearest{kInfinity, 0};
      for (std::uint32_t b = 0; b < rest_.size(); ++b) {
        if (!reached[b]) nearest = std::min(nearest, {norm2(rest_[a] - rest_[b]), b});
      }
      ties.emplace_back(nearest.first, a, nearest.second);
    }
    std::sort(ties.begin(), ties.end());
    for (std::size_t k = 0; k < std::min(kMaxTies, ties.size()); ++k) {
      add_edge(std::get<1>(ties[k]), std::get<2>(ties[k]), kWeakEdge);
    }
  }
}

// Sorts the nodes along the graph from one of its ends, so that a factor has few entries.
void CoarseBody::order() {
  const std::vector<std::uint32_t> list = breadth_first(edges_, breadth_first(edges_, 0).back());
  std::vector<std::uint32_t> number(list.size());
  for (std::uint32_t k = 0; k < list.size(); ++k) number[list[k]] = k;
  std::vector<Vec3d> rest;
  std::vector<std::vector<Edge>> edges;
  for (const std::uint32_t old : list) {
    rest.push_back(rest_[old]);
    edges.push_back(std::move(edges_[old]));
    for (Edge& edge : edges.back()) edge.to = number[edge.to];
    std::sort(edges.back().begin(), edges.back().end(), [](const Edge& a, const Edge& b) { return a.to < b.to; });
  }
  rest_ = std::move(rest);
  edges_ = std::move(edges);
}

std::uint32_t CoarseBody::nearest_node(const Vec3d& p) const {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < rest_.size(); ++i) {
    if (norm2(rest_[i] - p) < norm2(rest_[best] - p)) best = i;
  }
  return best;
}

std::vector<CoarseBody::Held> CoarseBody::held_by(std::span<const Anchor> anchors) const {
  std::vector<Held> held;
  for (const Anchor& anchor : anchors) {
    const std::uint32_t node = nearest_node(anchor.from);
    held.push_back({node, anchor.from - rest_[node], anchor.weight * unit_});
  }
  return held;
}

SymmetricMatrix CoarseBody::matrix_with(std::span<const Held> held) const {
  std::vector<double> diagonal(rest_.size(), 0);
  for (const Held& h : held) diagonal[h.node] += h.weight;
  SymmetricMatrix matrix;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    matrix.rows.push_back(static_cast<int>(i));
    matrix.values.push_back(diagonal[i]);
    const std::size_t first = matrix.values.size() - 1;
    for (const Edge& edge : edges_[i]) {
      matrix.values[first] += 2 * edge.weight;
      if (edge.to < i) continue;
      matrix.rows.push_back(static_cast<int>(edge.to));
      matrix.values.push_back(-2 * edge.weight);
    }
    matrix.begin.push_back(matrix.rows.size());
  }
  return matrix;
}

std::vector<Vec3d> CoarseBody::right_side(const std::vector<Quaternion>& turns) const {
  std::vector<Vec3d> right(rest_.size(), Vec3d{0, 0, 0});
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    for (const Edge& edge : edges_[i]) {
      const Vec3d d = rest_[i] - rest_[edge.to];
      right[i] += (turns[i] * d + turns[edge.to] * d) * edge.weight;
    }
  }
  return right;
}

void CoarseBody::find_turns() {
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    if (edges_[i].empty()) continue;
    Mat3d sum{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (const Edge& edge : edges_[i]) {
      sum = sum + outer_product(posed_[edge.to] - posed_[i], (rest_[edge.to] - rest_[i]) * edge.weight);
    }
    turns_[i] = nearest_turn(sum);
  }
}

void CoarseBody::iterate(const SparseCholesky& factor, std::span<const Held> held, std::span<const Vec3d> to) {
  std::vector<Vec3d> right = right_side(turns_);
  for (std::size_t k = 0; k < held.size(); ++k) {
    right[held[k].node] += (to[k] - turns_[held[k].node] * held[k].offset) * held[k].weight;
  }
  posed_ = solve(factor, right);
  find_turns();
}

void CoarseBody::pose(std::span<const Anchor> anchors, const Progress* progress) {
  if (anchors.empty()) return;
  std::vector<Held> held = held_by(anchors);
  SparseCholesky factor;
  factor.factorize(matrix_with(held), 1, progress);
  std::vector<Vec3d> to(anchors.size());
  const auto rounds = [&](double part, std::size_t count) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = anchors[k].from + (anchors[k].to - anchors[k].from) * part;
    for (std::size_t round = 0; round < count; ++round) {
      stop_if_cancelled(progress);
      iterate(factor, held, to);
    }
  };
  for (std::size_t k = 1; k <= kApproachSteps; ++k) rounds(static_cast<double>(k) / kApproachSteps, kStepRounds);
  const bool has_doubts =
      std::any_of(anchors.begin(), anchors.end(), [](const Anchor& anchor) { return anchor.is_doubtful; });
  for (std::size_t again = 0; again < 3 && has_doubts; ++again) {
    std::vector<double> distances;
    for (std::size_t k = 0; k < held.size(); ++k) {
      const Vec3d place = posed_[held[k].node] + turns_[held[k].node] * held[k].offset;
      distances.push_back(norm(place - anchors[k].to));
    }
    std::vector<double> sorted = distances;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double far = kDoubtFactor * sorted[sorted.size() / 2];
    for (std::size_t k = 0; k < held.size(); ++k) {
      if (!anchors[k].is_doubtful || !(far > 0)) continue;
      const double ratio = distances[k] / far;
      held[k].weight = anchors[k].weight * unit_ / ((1 + ratio * ratio) * (1 + ratio * ratio));
    }
    factor.factorize(matrix_with(held), 1, progress);
    rounds(1, kLastRounds / 4);
  }
  rounds(1, kLastRounds);
}

// Returns the node that moves and turns least: the others turn about it.
std::uint32_t CoarseBody::calmest_node() const {
  constexpr double kTurnLength = 0.25;  // of the body's extent: the weight of half a turn
  Box box;
  for (const Vec3d& p : rest_) box.extend(p);
  const auto motion = [&](std::uint32_t i) {
    return norm(posed_[i] - rest_[i]) + kTurnLength * box.diagonal() * norm(turns_[i].v);
  };
  std::uint32_t calmest = 0;
  for (std::uint32_t i = 1; i < rest_.size(); ++i) calmest = motion(i) < motion(calmest) ? i : calmest;
  return calmest;
}

// Returns the steps {node, node before} of the tree of edges along which turns differ least: across a crushed joint
// they may differ by any angle.
std::vector<std::pair<std::uint32_t, std::uint32_t>> CoarseBody::steps_from(std::uint32_t root) const {
  using Step = std::tuple<double, std::uint32_t, std::uint32_t>;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> next;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> steps;
  std::vector<bool> reached(rest_.size(), false);
  next.emplace(0, root, root);
  while (!next.empty()) {
    const auto [cost, node, from] = next.top();
    next.pop();
    if (reached[node]) continue;
    reached[node] = true;
    steps.emplace_back(node, from);
    for (const Edge& edge : edges_[node]) {
      if (!reached[edge.to]) next.emplace(norm((inverse(turns_[node]) * turns_[edge.to]).v), edge.to, node);
    }
  }
  return steps;
}

std::vector<std::vector<Vec3d>> CoarseBody::paths(std::span<const Anchor> anchors, std::size_t pieces) const {
  const std::uint32_t root = calmest_node();
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> steps = steps_from(root);
  const std::vector<Held> held = held_by(anchors);
  const Held pin{root, {0, 0, 0}, unit_};
  SparseCholesky factor;
  factor.factorize(matrix_with({&pin, 1}), 1);
  std::vector<Quaternion> turns(rest_.size());
  const auto anchors_at = [&](double time) {
    turns[root] = part_of(turns_[root], time);
    for (std::size_t k = 1; k < steps.size(); ++k) {
      const auto [node, from] = steps[k];
      turns[node] = turns[from] * part_of(inverse(turns_[from]) * turns_[node], time);
    }
    std::vector<Vec3d> right = right_side(turns);
    right[root] += (rest_[root] * (1 - time) + posed_[root] * time) * pin.weight;
    const std::vector<Vec3d> places = solve(factor, right);
    std::vector<Vec3d> at;
    at.reserve(held.size());
    for (const Held& h : held) at.push_back(places[h.node] + turns[h.node] * h.offset);
    return at;
  };
  const std::vector<Vec3d> last = anchors_at(1);
  std::vector<std::vector<Vec3d>> result(anchors.size());
  for (std::size_t k = 0; k <= pieces; ++k) {
    const double time = static_cast<double>(k) / static_cast<double>(pieces);
    const std::vector<Vec3d> at = anchors_at(time);
    for (std::size_t a = 0; a < anchors.size(); ++a) {
      result[a].push_back(at[a] + (anchors[a].to - last[a]) * time);
    }
  }
  for (std::size_t a = 0; a < anchors.size(); ++a) {
    result[a].front() = anchors[a].from;
    result[a].back() = anchors[a].to;
  }
  return result;
}

std::vector<SurfaceSample> CoarseBody::posed(std::span<const SurfaceSample> samples) const {
  std::vector<SurfaceSample> result;
  result.reserve(samples.size());
  for (const SurfaceSample& s : samples) {
    const std::uint32_t node = nearest_node(s.point);
    result.push_back({posed_[node] + turns_[node] * (s.point - rest_[node]), turns_[node] * s.normal});
  }
  return result;
}

std::vector<Anchor> CoarseBody::node_anchors() const {
  std::vector<Anchor> anchors;
  for (std::size_t i = 0; i < rest_.size(); ++i) anchors.push_back({rest_[i], posed_[i]});
  return anchors;
}

std::vector<double> CoarseBody::distances_from(std::uint32_t node) const {
  std::vector<double> distance(rest_.size(), kInfinity);
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(distance[node] = 0, node);
  while (!queue.empty()) {
    const auto [d, at] = queue.top();
    queue.pop();
    if (d > distance[at]) continue;
    for (const Edge& edge : edges_[at]) {
      const double through = d + norm(rest_[edge.to] - rest_[at]);
      if (through < distance[edge.to]) queue.emplace(distance[edge.to] = through, edge.to);
    }
  }
  return distance;
}

Vec3d place_on(const std::vector<Vec3d>& path, double time) {
  const double at = time * static_cast<double>(path.size() - 1);
  const auto piece = std::min(static_cast<std::size_t>(at), path.size() - 2);
  const double rest = at - static_cast<double>(piece);
  return path[piece] * (1 - rest) + path[piece + 1] * rest;
}

double length_of_path(const std::vector<Vec3d>& path) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) length += norm(path[i + 1] - path[i]);
  return length;
}

}  // namespace knead::detail
