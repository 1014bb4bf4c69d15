#include "math/sparse_cholesky.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "knead/error.h"

namespace knead::detail {

namespace {

constexpr std::size_t kPanel = 8;           // columns that are taken from the others together
constexpr std::size_t kPairsOfThread = 64;  // of columns, at least
constexpr std::size_t kWideEnough = 16;     // narrower fronts are joined with their parent where that adds few zeros
constexpr double kMaxZeros = 0.15;          // of the joined front

// Two columns, and the factors with which a panel's columns are taken from them.
struct TwoColumns {
  double* c = nullptr;
  double* d = nullptr;
  double by_c[kPanel]{};
  double by_d[kPanel]{};
};

// Takes the panel's columns, which lie `stride` apart, from two columns of `count` numbers.
KNEAD_CLONES void subtract_panel(const double* __restrict panel, std::size_t stride, std::size_t count,
                                 const TwoColumns& from) {
  double* __restrict const c = from.c;
  double* __restrict const d = from.d;
  double by_c[kPanel];
  double by_d[kPanel];
  std::copy_n(from.by_c, kPanel, by_c);
  std::copy_n(from.by_d, kPanel, by_d);
  for (std::size_t i = 0; i < count; ++i) {
    double of_c = c[i];
    double of_d = d[i];
    for (std::size_t k = 0; k < kPanel; ++k) {
      of_c -= panel[k * stride + i] * by_c[k];
      of_d -= panel[k * stride + i] * by_d[k];
    }
    c[i] = of_c;
    d[i] = of_d;
  }
}

KNEAD_CLONES void subtract_column(const double* __restrict column, std::size_t count, double by, double* __restrict c) {
  for (std::size_t i = 0; i < count; ++i) c[i] -= column[i] * by;
}

// A dense symmetric matrix whose first columns are eliminated; only its lower triangle is used.
struct DenseFront {
  std::size_t size = 0;
  std::vector<double> numbers;  // by columns

  double* column(std::size_t j) { return numbers.data() + j * size; }

  // Factorises the columns from `begin` to `end`, which nothing before them changes any more.
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
    for (std::size_t begin = 0; begin < width; begin += kPanel) {
      const std::size_t end = std::min(begin + kPanel, width);
      if (!factorize_panel(begin, end)) return false;
      const std::size_t pairs = end - begin == kPanel ? (size - end) / 2 : 0;
      parallel_for(pairs, kPairsOfThread, threads, [&](std::size_t first, std::size_t last) {
        for (std::size_t pair = first; pair < last; ++pair) take_panel_from_two(begin, end + 2 * pair);
      });
      for (std::size_t j = end + 2 * pairs; j < size; ++j) {
        for (std::size_t k = begin; k < end; ++k) subtract_column(column(k) + j, size - j, column(k)[j], column(j) + j);
      }
    }
    return true;
  }

 private:
  void take_panel_from_two(std::size_t begin, std::size_t j) {
    TwoColumns two;
    for (std::size_t k = 0; k < kPanel; ++k) {
      two.by_c[k] = column(begin + k)[j];
      two.by_d[k] = column(begin + k)[j + 1];
    }
    double above[1] = {0};  // the second column has no number in the first one's row
    two.c = column(j) + j;
    two.d = above;
    subtract_panel(column(begin) + j, size, 1, two);
    two.c = column(j) + j + 1;
    two.d = column(j + 1) + j + 1;
    subtract_panel(column(begin) + j + 1, size, size - j - 1, two);
  }
};

// The rows of each column of L below the diagonal, ascending.
std::vector<std::vector<int>> rows_of_factor(const SymmetricMatrix& matrix) {
  const std::size_t size = matrix.size();
  std::vector<std::vector<int>> rows(size);
  std::vector<std::vector<int>> children(size);
  std::vector<int> mark(size, -1);
  for (std::size_t j = 0; j < size; ++j) {
    std::vector<int>& own = rows[j];
    const int column = static_cast<int>(j);
    const auto add = [&](int row) {
      if (row <= column || mark[static_cast<std::size_t>(row)] == column) return;
      mark[static_cast<std::size_t>(row)] = column;
      own.push_back(row);
    };
    for (std::size_t i = matrix.begin[j]; i < matrix.begin[j + 1]; ++i) add(matrix.rows[i]);
    for (const int child : children[j]) {
      for (const int row : rows[static_cast<std::size_t>(child)]) add(row);
    }
    std::sort(own.begin(), own.end());
    if (!own.empty()) children[static_cast<std::size_t>(own.front())].push_back(column);
  }
  return rows;
}

}  // namespace

void SparseCholesky::find_fronts(const SymmetricMatrix& matrix) {
  const std::vector<std::vector<int>> rows = rows_of_factor(matrix);
  fronts_.clear();
  // A column joins the one before it if that has the same rows below, or nearly so.
  double zeros = 0;
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const int column = static_cast<int>(j);
    Front* const last = fronts_.empty() ? nullptr : &fronts_.back();
    const bool is_parent = last != nullptr && !rows[j - 1].empty() && rows[j - 1].front() == column;
    if (is_parent) {
      const auto missing = static_cast<double>(rows[j].size() + 1 - rows[j - 1].size());
      const double more = zeros + missing * last->width;
      const double entries = (last->width + 1.0) * static_cast<double>(rows[j].size() + 1);
      if (missing == 0 || (last->width < static_cast<int>(kWideEnough) && more < kMaxZeros * entries)) {
        ++last->width;
        zeros = more;
        continue;
      }
    }
    fronts_.push_back({column, 1, {}, {}, {}});
    zeros = 0;
  }
  std::vector<std::size_t> front_of(rows.size());
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    Front& front = fronts_[f];
    for (int k = 0; k < front.width; ++k) {
      front.rows.push_back(front.first + k);
      front_of[static_cast<std::size_t>(front.rows.back())] = f;
    }
    const std::vector<int>& below = rows[static_cast<std::size_t>(front.first + front.width - 1)];
    front.rows.insert(front.rows.end(), below.begin(), below.end());
  }
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    const Front& front = fronts_[f];
    const auto width = static_cast<std::size_t>(front.width);
    if (front.rows.size() > width) fronts_[front_of[static_cast<std::size_t>(front.rows[width])]].children.push_back(f);
  }
}

bool SparseCholesky::factorize(const SymmetricMatrix& matrix, int threads, const Progress* progress) {
  if (matrix.begin != begin_ || matrix.rows != rows_) {
    find_fronts(matrix);
    begin_ = matrix.begin;
    rows_ = matrix.rows;
  }
  std::vector<DenseFront> rests(fronts_.size());  // what each front leaves to its parent
  std::vector<std::size_t> place(matrix.size());  // of a row in the front
  DenseFront dense;
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    stop_if_cancelled(progress);
    Front& front = fronts_[f];
    const auto width = static_cast<std::size_t>(front.width);
    dense.size = front.rows.size();
    dense.numbers.assign(dense.size * dense.size, 0.0);
    for (std::size_t i = 0; i < dense.size; ++i) place[static_cast<std::size_t>(front.rows[i])] = i;
    for (std::size_t k = 0; k < width; ++k) {
      const std::size_t j = static_cast<std::size_t>(front.first) + k;
      for (std::size_t i = matrix.begin[j]; i < matrix.begin[j + 1]; ++i) {
        dense.column(k)[place[static_cast<std::size_t>(matrix.rows[i])]] += matrix.values[i];
      }
    }
    for (const std::size_t child : front.children) {
      const int* const rows = fronts_[child].rows.data() + fronts_[child].width;
      DenseFront& rest = rests[child];
      for (std::size_t j = 0; j < rest.size; ++j) {
        double* const to = dense.column(place[static_cast<std::size_t>(rows[j])]);
        for (std::size_t i = j; i < rest.size; ++i) to[place[static_cast<std::size_t>(rows[i])]] += rest.column(j)[i];
      }
      rest = {};
    }
    if (!dense.eliminate(width, threads)) return false;
    front.columns.assign(dense.column(0), dense.column(0) + width * dense.size);
    DenseFront& rest = rests[f];
    rest.size = dense.size - width;
    rest.numbers.resize(rest.size * rest.size);
    for (std::size_t j = 0; j < rest.size; ++j) {
      std::copy_n(dense.column(width + j) + width, rest.size, rest.column(j));
    }
  }
  return true;
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
