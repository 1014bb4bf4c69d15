// The Cholesky factorisation of a sparse matrix, in dense blocks.
//
// Eigen's takes five times as long, because it sums one number at a time; CHOLMOD's is as fast, but its bits depend on
// the machine's BLAS (docs/decisions/0029-poses.md).
#pragma once

#include <cstddef>
#include <vector>

#include "knead/error.h"

namespace knead::detail {

// The lower triangle of a symmetric matrix, by columns. The rows of a column ascend, and begin with the diagonal.
struct SymmetricMatrix {
  std::vector<std::size_t> begin{0};  // of each column, and the end of the last
  std::vector<int> rows;
  std::vector<double> values;

  std::size_t size() const { return begin.size() - 1; }
};

// The factor L of A = L L^T, by the multifrontal method (Duff and Reid 1983): columns with the same rows are factorised
// together, as a dense matrix. The columns must be in an order with little fill, such as nested dissection. Successive
// matrices of the same pattern share its analysis. Sums run in one order: the same bits for every instruction set.
class SparseCholesky {
 public:
  // Returns false if the matrix is not positive definite. Time: 0.02 s for 1800 unknowns. threads as for parallel_for;
  // the bits do not depend on them. Throws Cancelled.
  bool factorize(const SymmetricMatrix& matrix, int threads = 0, const Progress* progress = nullptr);

  // Replaces b, one number for each column, by the solution of A x = b.
  void solve(std::vector<double>& b) const;

 private:
  // `width` columns from `first` on that share their rows.
  struct Front {
    int first = 0;
    int width = 0;
    std::vector<int> rows;        // first to first + width - 1, and those below, ascending
    std::vector<double> columns;  // of L: `width` columns of rows.size() numbers
    std::vector<std::size_t> children;
  };

  class Elimination;

  void find_fronts(const SymmetricMatrix& matrix);

  std::vector<Front> fronts_;
  std::vector<std::size_t> begin_;  // the pattern of the fronts
  std::vector<int> rows_;
};

}  // namespace knead::detail
