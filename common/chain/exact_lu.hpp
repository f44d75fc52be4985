// One sparse LU factorisation at a time: KLU of SuiteSparse, through Eigen. Pivots stay on the diagonal and no row is
// scaled, which is sound for the matrices that it is meant for (I - P transposed, P substochastic: diagonally dominant
// by columns) and leaves nothing to chance: the same matrix gives the same factors, bit for bit. Memory of one thread.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace coppice {

// Of L and U together: 16 bytes each. Sparse chains stay far below; a large and random one may not.
inline constexpr double kMaxFactorEntries = 134217728.0;  // 2^27

// Column by column; rows within a column are distinct, in any order.
struct SparseColumns {
  std::vector<int> begin;  // [columns + 1]
  std::vector<int> row;
  std::vector<double> value;
};

class SparseLu {
 public:
  SparseLu();
  SparseLu(const SparseLu&) = delete;
  SparseLu& operator=(const SparseLu&) = delete;
  ~SparseLu();

  // False: singular to working precision, or beyond kMaxFactorEntries. REQUIRES: square, a diagonal without zeros.
  [[nodiscard]] bool factorise(const SparseColumns& matrix);
  // The same by the order of elimination that `alike` found for its own matrix, of as many columns: right for any
  // matrix, and a third to a half of the time for one whose entries stand in nearly the same places. REQUIRES: as
  // factorise(); alike.factorise() was true.
  [[nodiscard]] bool factorise_alike(const SparseColumns& matrix, const SparseLu& alike);
  // b becomes x of A x = b. REQUIRES: factorise() was true, b.size() == columns.
  void solve(std::vector<double>& b) const;
  // b becomes x of (A transposed) x = b, by the same factors. REQUIRES: as solve().
  void solve_transposed(std::vector<double>& b) const;

 private:
  struct Klu;
  bool factorise(const SparseColumns& matrix, const SparseLu* alike);

  std::unique_ptr<Klu> klu_;
};

}  // namespace coppice
