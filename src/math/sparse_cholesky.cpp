// The multifrontal Cholesky factorisation: the fronts of a matrix, and their elimination in parallel subtrees.
#include "math/sparse_cholesky.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "knead/error.h"
#include "math/system.h"

namespace knead::detail {

namespace {

constexpr std::size_t kPanel = 8;              // columns that are subtracted from the others together
constexpr std::size_t kWidePanel = 32;         // columns that are subtracted before the next are factorised
constexpr std::size_t kColumnsAtOnce = 4;      // from which a panel is subtracted
constexpr std::size_t kAligned = 8;            // numbers of the widest registers
constexpr std::size_t kMinGroupsOfThread = 8;  // of kColumnsAtOnce columns
constexpr int kMinFrontWidth = 16;             // narrower fronts join their parent if that adds few zeros
constexpr double kMaxZeroShare = 0.15;         // of the joined front
constexpr double kMaxSubtreeWork = 0.1;        // of the whole work
constexpr std::size_t kNoSubtree = std::numeric_limits<std::size_t>::max();

// Columns, and the factors with which a panel's columns are subtracted from them.
struct Columns {
  double* columns[kColumnsAtOnce]{};
  double by[kColumnsAtOnce][kPanel]{};
};

// Subtracts the panel's columns, which lie `stride` apart, from columns of `count` numbers. All are aligned to
// registers, and count is a multiple of kAligned.
KNEAD_CLONES void subtract_panel(const double* panel, std::size_t stride, std::size_t count, const Columns& from) {
  using Numbers [[gnu::vector_size(kAligned * sizeof(double))]] = double;
  for (std::size_t i = 0; i < count; i += kAligned) {
    Numbers of[kColumnsAtOnce];
    for (std::size_t c = 0; c < kColumnsAtOnce; ++c) of[c] = *reinterpret_cast<const Numbers*>(from.columns[c] + i);
    for (std::size_t k = 0; k < kPanel; ++k) {
      const Numbers numbers = *reinterpret_cast<const Numbers*>(panel + k * stride + i);
      for (std::size_t c = 0; c < kColumnsAtOnce; ++c) of[c] -= numbers * from.by[c][k];
    }
    for (std::size_t c = 0; c < kColumnsAtOnce; ++c) *reinterpret_cast<Numbers*>(from.columns[c] + i) = of[c];
  }
}

KNEAD_CLONES void subtract_column(const double* __restrict column, std::size_t count, double by, double* __restrict c) {
  for (std::size_t i = 0; i < count; ++i) c[i] -= column[i] * by;
}

// A dense symmetric matrix whose first columns are eliminated. Only its lower triangle is used, and starts as 0; some
// numbers above it are written too, so that all accesses are aligned.
class DenseFront {
 public:
  explicit DenseFront(std::size_t rows)
      : size(rows),
        stride_((rows + kAligned - 1) / kAligned * kAligned),
        numbers_(new double[stride_ * size + kAligned]) {
    void* first = numbers_.get();
    std::size_t space = (stride_ * size + kAligned) * sizeof(double);
    first_ = static_cast<double*>(std::align(kAligned * sizeof(double), stride_ * size * sizeof(double), first, space));
    for (std::size_t j = 0; j < size; ++j) std::fill(column(j) + aligned(j), column(j) + stride_, 0.0);
  }

  std::size_t size;

  double* column(std::size_t j) { return first_ + j * stride_; }

  // Factorises the columns from `begin` to `end`, from which all columns before them have been subtracted.
  bool factorize_panel(std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      double* const c = column(j);
      for (std::size_t k = begin; k < j; ++k) subtract_column(column(k) + j, size - j, column(k)[j], c + j);
      if (!(c[j] > 0)) return false;
      const double root = std::sqrt(c[j]);
      const double by = 1 / root;
      c[j] = root;
      for (std::size_t i = j + 1; i < size; ++i) c[i] *= by;
    }
    return true;
  }

  bool eliminate(std::size_t width, int threads) {
    for (std::size_t begin = 0; begin < width; begin += kWidePanel) {
      const std::size_t end = std::min(begin + kWidePanel, width);
      for (std::size_t panel = begin; panel < end; panel += kPanel) {
        const std::size_t next = std::min(panel + kPanel, end);
        if (!factorize_panel(panel, next)) return false;
        subtract_panel_from(panel, next - panel, next, end);
      }
      const std::size_t groups = (size - end + kColumnsAtOnce - 1) / kColumnsAtOnce;
      parallel_for(groups, kMinGroupsOfThread, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t group = first; group < last; ++group) {
          const std::size_t j = end + kColumnsAtOnce * group;
          for (std::size_t panel = begin; panel < end; panel += kPanel) {
            subtract_panel_from(panel, std::min(kPanel, end - panel), j, std::min(j + kColumnsAtOnce, size));
          }
        }
      });
    }
    return true;
  }

 private:
  static std::size_t aligned(std::size_t row) { return row / kAligned * kAligned; }

  // Subtracts `width` columns from `begin` on, a panel at most, from those from `first` to `last`.
  void subtract_panel_from(std::size_t begin, std::size_t width, std::size_t first, std::size_t last) {
    std::size_t j = first;
    for (; width == kPanel && j + kColumnsAtOnce <= last; j += kColumnsAtOnce) {
      Columns columns;
      for (std::size_t c = 0; c < kColumnsAtOnce; ++c) {
        columns.columns[c] = column(j + c) + aligned(j);
        for (std::size_t k = 0; k < kPanel; ++k) columns.by[c][k] = column(begin + k)[j + c];
      }
      subtract_panel(column(begin) + aligned(j), stride_, stride_ - aligned(j), columns);
    }
    for (; j < last; ++j) {
      for (std::size_t k = begin; k < begin + width; ++k) {
        subtract_column(column(k) + j, size - j, column(k)[j], column(j) + j);
      }
    }
  }

  std::size_t stride_;  // from column to column
  std::unique_ptr<double[]> numbers_;
  double* first_ = nullptr;
};

// Rows below the diagonal of a column, as bits.
class RowBits {
 public:
  RowBits(std::size_t column, std::size_t size)
      : first_word_(column / kBits), words_((size + kBits - 1) / kBits - first_word_) {}

  void add(std::size_t row) { words_[row / kBits - first_word_] |= std::uint64_t{1} << row % kBits; }
  void remove(std::size_t row) { words_[row / kBits - first_word_] &= ~(std::uint64_t{1} << row % kBits); }

  // Adds those of a column before this one.
  void add(const RowBits& other) {
    const std::uint64_t* const from = other.words_.data() + (first_word_ - other.first_word_);
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] |= from[i];
  }

  std::size_t count() const {
    std::size_t sum = 0;
    for (const std::uint64_t word : words_) sum += static_cast<std::size_t>(std::popcount(word));
    return sum;
  }

  // Calls visit(row) for each row, ascending, until that returns false.
  template <class Visit>
  void visit(const Visit& visit) const {
    for (std::size_t i = 0; i < words_.size(); ++i) {
      for (std::uint64_t word = words_[i]; word != 0; word &= word - 1) {
        if (!visit(kBits * (first_word_ + i) + static_cast<std::size_t>(std::countr_zero(word)))) return;
      }
    }
  }

  std::optional<std::size_t> first() const {
    std::optional<std::size_t> result;
    visit([&](std::size_t row) {
      result = row;
      return false;
    });
    return result;
  }

 private:
  static constexpr std::size_t kBits = 64;

  std::size_t first_word_;
  std::vector<std::uint64_t> words_;
};

// The rows of each column of L below the diagonal.
std::vector<RowBits> rows_of_factor(const SymmetricMatrix& matrix) {
  const std::size_t size = matrix.size();
  std::vector<RowBits> rows;
  std::vector<std::vector<std::size_t>> children(size);
  rows.reserve(size);
  for (std::size_t j = 0; j < size; ++j) {
    RowBits& own = rows.emplace_back(j, size);
    for (std::size_t i = matrix.begin[j]; i < matrix.begin[j + 1]; ++i)
      own.add(static_cast<std::size_t>(matrix.rows[i]));
    for (const std::size_t child : children[j]) own.add(rows[child]);
    own.remove(j);
    if (const std::optional<std::size_t> parent = own.first()) children[*parent].push_back(j);
  }
  return rows;
}

}  // namespace

void SparseCholesky::find_fronts(const SymmetricMatrix& matrix) {
  const std::vector<RowBits> rows = rows_of_factor(matrix);
  fronts_.clear();
  // A column joins the one before it if that has the same rows below, or nearly so.
  double zeros = 0;
  std::size_t count_before = 0;
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const std::size_t count = rows[j].count();
    const std::size_t before = std::exchange(count_before, count);
    if (j > 0 && rows[j - 1].first() == j) {
      Front& last = fronts_.back();
      const auto missing = static_cast<double>(count + 1 - before);
      const double more = zeros + missing * last.width;
      const double entries = (last.width + 1.0) * static_cast<double>(count + 1);
      if (missing == 0 || (last.width < kMinFrontWidth && more < kMaxZeroShare * entries)) {
        ++last.width;
        zeros = more;
        continue;
      }
    }
    fronts_.push_back({static_cast<int>(j), 1, {}, {}, {}});
    zeros = 0;
  }
  std::vector<std::size_t> front_of(rows.size());
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    Front& front = fronts_[f];
    for (int k = 0; k < front.width; ++k) {
      front.rows.push_back(front.first + k);
      front_of[static_cast<std::size_t>(front.rows.back())] = f;
    }
    rows[static_cast<std::size_t>(front.rows.back())].visit([&](std::size_t row) {
      front.rows.push_back(static_cast<int>(row));
      return true;
    });
  }
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    const Front& front = fronts_[f];
    const auto width = static_cast<std::size_t>(front.width);
    if (front.rows.size() > width) fronts_[front_of[static_cast<std::size_t>(front.rows[width])]].children.push_back(f);
  }
}

// The fronts of a matrix while they are factorised, each after its children.
class SparseCholesky::Elimination {
 public:
  Elimination(const SymmetricMatrix& matrix, std::vector<Front>& fronts, const Progress* progress)
      : matrix_(matrix), fronts_(fronts), rests_(fronts.size()), progress_(progress) {}

  // Eliminates subtrees in parallel, then the fronts above them.
  bool run(int threads) {
    const std::vector<std::vector<std::size_t>> parts = divided();
    std::atomic<bool> is_definite = true;
    parallel_for(parts.size() - 1, 1, threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        if (!eliminate(parts[i], 1)) is_definite = false;
      }
    });
    return is_definite && eliminate(parts.back(), threads);
  }

 private:
  // The columns of a front from its width on, for its parent.
  using Rest = std::optional<DenseFront>;

  // Returns the fronts of small subtrees, and last the fronts above them. All ascend.
  std::vector<std::vector<std::size_t>> divided() const {
    std::vector<double> work(fronts_.size());
    std::vector<bool> is_child(fronts_.size(), false);
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      const auto size = static_cast<double>(fronts_[f].rows.size());
      work[f] += size * size * fronts_[f].width;
      for (const std::size_t child : fronts_[f].children) {
        work[f] += work[child];
        is_child[child] = true;
      }
    }
    double whole = 0;
    for (std::size_t f = 0; f < fronts_.size(); ++f) whole += is_child[f] ? 0 : work[f];
    std::vector<std::vector<std::size_t>> parts;
    std::vector<std::size_t> part_of(fronts_.size(), kNoSubtree);
    for (std::size_t f = fronts_.size(); f-- > 0;) {
      if (part_of[f] == kNoSubtree && work[f] < kMaxSubtreeWork * whole) {
        part_of[f] = parts.size();
        parts.emplace_back();
      }
      for (const std::size_t child : fronts_[f].children) part_of[child] = part_of[f];
    }
    parts.emplace_back();
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      (part_of[f] == kNoSubtree ? parts.back() : parts[part_of[f]]).push_back(f);
    }
    return parts;
  }

  bool eliminate(const std::vector<std::size_t>& part, int threads) {
    std::vector<std::size_t> place(matrix_.size());  // of a row in the front
    for (const std::size_t f : part) {
      stop_if_cancelled(progress_);
      Front& front = fronts_[f];
      const auto width = static_cast<std::size_t>(front.width);
      DenseFront dense(front.rows.size());
      for (std::size_t i = 0; i < dense.size; ++i) place[static_cast<std::size_t>(front.rows[i])] = i;
      for (std::size_t k = 0; k < width; ++k) {
        const std::size_t j = static_cast<std::size_t>(front.first) + k;
        for (std::size_t i = matrix_.begin[j]; i < matrix_.begin[j + 1]; ++i) {
          dense.column(k)[place[static_cast<std::size_t>(matrix_.rows[i])]] += matrix_.values[i];
        }
      }
      for (const std::size_t child : front.children) add_rest(child, place, dense);
      if (!dense.eliminate(width, threads)) return false;
      front.columns.clear();
      for (std::size_t k = 0; k < width; ++k) {
        front.columns.insert(front.columns.end(), dense.column(k), dense.column(k) + dense.size);
      }
      if (width < dense.size) rests_[f].emplace(std::move(dense));
    }
    return true;
  }

  void add_rest(std::size_t child, const std::vector<std::size_t>& place, DenseFront& to) {
    DenseFront& from = *rests_[child];
    const auto width = static_cast<std::size_t>(fronts_[child].width);
    std::vector<std::size_t> at;
    for (const int row : fronts_[child].rows) at.push_back(place[static_cast<std::size_t>(row)]);
    // The ends of runs of rows that are contiguous in both.
    std::vector<std::size_t> ends(from.size);
    for (std::size_t i = from.size; i-- > width;) {
      ends[i] = i + 1 < from.size && at[i + 1] == at[i] + 1 ? ends[i + 1] : i + 1;
    }
    for (std::size_t j = width; j < from.size; ++j) {
      const double* const column = from.column(j);
      for (std::size_t i = j; i < from.size; i = ends[i]) {
        double* const place_of_run = to.column(at[j]) + at[i];
        for (std::size_t k = i; k < ends[i]; ++k) place_of_run[k - i] += column[k];
      }
    }
    rests_[child].reset();
  }

  const SymmetricMatrix& matrix_;
  std::vector<Front>& fronts_;
  std::vector<Rest> rests_;
  const Progress* progress_;
};

bool SparseCholesky::factorize(const SymmetricMatrix& matrix, int threads, const Progress* progress) {
  if (matrix.begin != begin_ || matrix.rows != rows_) {
    find_fronts(matrix);
    begin_ = matrix.begin;
    rows_ = matrix.rows;
  }
  return Elimination(matrix, fronts_, progress).run(threads);
}

void SparseCholesky::solve(std::vector<double>& b) const {
  for (const Front& front : fronts_) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(front.width); ++k) {
      const double* const column = front.columns.data() + k * front.rows.size();
      const double x = b[static_cast<std::size_t>(front.rows[k])] / column[k];
      b[static_cast<std::size_t>(front.rows[k])] = x;
      for (std::size_t i = k + 1; i < front.rows.size(); ++i)
        b[static_cast<std::size_t>(front.rows[i])] -= column[i] * x;
    }
  }
  for (std::size_t f = fronts_.size(); f-- > 0;) {
    const Front& front = fronts_[f];
    for (std::size_t k = static_cast<std::size_t>(front.width); k-- > 0;) {
      const double* const column = front.columns.data() + k * front.rows.size();
      double x = b[static_cast<std::size_t>(front.rows[k])];
      for (std::size_t i = k + 1; i < front.rows.size(); ++i)
        x -= column[i] * b[static_cast<std::size_t>(front.rows[i])];
      b[static_cast<std::size_t>(front.rows[k])] = x / column[k];
    }
  }
}

}  // namespace knead::detail
