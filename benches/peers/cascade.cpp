// A hierarchy as one quadratic program a level, solved by eiquadprog: what a controller in C++ does without a solver of hierarchies.
//
// A level of hard rows is a constraint of all programs below it. A soft level minimises
//
//     sum_i w_i |a_i x - b_i|^2 + sum_j w_j s_j^2 + EPS |x|^2      equality rows in the cost, a slack for each other row
//
// within those above: their equality rows at the values that they reached, their other rows at their bounds, moved out by
// the slack that they took and ROOM. Built by `peers.py`; called by ctypes.

#include <ctime>
#include <vector>

#include <Eigen/Dense>
#include <eiquadprog/eiquadprog-fast.hpp>

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

static const double EPS = 1e-6;
static const double ROOM = 1e-8;  // to rounding, bounds that are reached contradict each other

static double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * 1e6 + t.tv_nsec * 1e-3;
}

struct Rows {
  std::vector<Eigen::VectorXd> a;
  std::vector<double> b;
  void push(const Eigen::VectorXd& row, double value) {
    a.push_back(row);
    b.push_back(value);
  }
};

// Solves one hierarchy. `a`, `lower`, `upper`, `weight` hold the rows of all levels, one level after the other; `hard` is 1 for hard
// levels. Writes `x` and the CPU time in microseconds; returns 0, or what eiquadprog said of the level that it could not solve.
extern "C" int cascade(int n, int levels, const int* rows, const int* hard, const double* a, const double* lower,
                       const double* upper, const double* weight, double* x_out, double* us) {
  const double start = now();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  Rows equal, above;
  eiquadprog::solvers::EiquadprogFast solver;
  int first = 0, failed = 0;
  for (int l = 0; l < levels; first += rows[l], ++l) {
    Eigen::Map<const Matrix> A(a + static_cast<long>(first) * n, rows[l], n);
    std::vector<int> wishes, limits;
    for (int i = 0; i < rows[l]; ++i) {
      const int at = first + i;
      if (lower[at] == upper[at]) {
        if (hard[l]) equal.push(A.row(i), lower[at]);
        else if (weight[at] > 0) wishes.push_back(i);
      } else if (hard[l]) {
        if (lower[at] > -1e300) above.push(A.row(i), -lower[at]);
        if (upper[at] < 1e300) above.push(-A.row(i), upper[at]);
      } else if (weight[at] > 0 && (lower[at] > -1e300 || upper[at] < 1e300)) {
        limits.push_back(i);
      }
    }
    if (wishes.empty() && limits.empty()) continue;
    const int size = n + static_cast<int>(limits.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(size), z(size);
    H.topLeftCorner(n, n).diagonal().setConstant(EPS);
    for (int i : wishes) {
      const double w = weight[first + i];
      H.topLeftCorner(n, n).noalias() += w * A.row(i).transpose() * A.row(i);
      g.head(n) -= w * lower[first + i] * A.row(i).transpose();
    }
    for (size_t j = 0; j < limits.size(); ++j) H(n + j, n + j) = weight[first + limits[j]];
    Eigen::MatrixXd CE = Eigen::MatrixXd::Zero(equal.a.size(), size);
    Eigen::VectorXd ce(equal.a.size());
    for (size_t i = 0; i < equal.a.size(); ++i) {
      CE.row(i).head(n) = equal.a[i];
      ce[i] = -equal.b[i];
    }
    Rows own;
    std::vector<std::pair<int, double>> side;
    for (size_t j = 0; j < limits.size(); ++j) {
      const int at = first + limits[j];
      if (lower[at] > -1e300) own.push(A.row(limits[j]), -lower[at]), side.push_back({j, 1.0});
      if (upper[at] < 1e300) own.push(-A.row(limits[j]), upper[at]), side.push_back({j, 1.0});
    }
    const size_t m = above.a.size();
    Eigen::MatrixXd CI = Eigen::MatrixXd::Zero(m + own.a.size(), size);
    Eigen::VectorXd ci(m + own.a.size());
    for (size_t i = 0; i < m; ++i) {
      CI.row(i).head(n) = above.a[i];
      ci[i] = above.b[i];
    }
    for (size_t i = 0; i < own.a.size(); ++i) {
      CI.row(m + i).head(n) = own.a[i];
      CI(m + i, n + side[i].first) = side[i].second;
      ci[m + i] = own.b[i];
    }
    solver.reset(size, equal.a.size(), ci.size());
    const auto status = solver.solve_quadprog(H, g, CE, ce, CI, ci, z);
    if (status != eiquadprog::solvers::EIQUADPROG_FAST_OPTIMAL) {
      failed = 1 + static_cast<int>(status);
      break;
    }
    x = z.head(n);
    for (int i : wishes) equal.push(A.row(i), A.row(i).dot(x));
    for (size_t i = 0; i < own.a.size(); ++i) {
      above.push(own.a[i], own.b[i] + std::max(0.0, ROOM - (own.a[i].dot(x) + own.b[i])));
    }
  }
  Eigen::VectorXd::Map(x_out, n) = x;
  *us = now() - start;
  return failed;
}
