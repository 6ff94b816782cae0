// Gauss-Legendre quadrature over [0, 1]: few nodes integrate a smooth function to many digits.
//
// Space    none.
// Threads  any.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace occam::shade {

/// One node of a rule: the integral of f over [0, 1] is the sum of weight * f(x).
struct QuadratureNode {
    double x = 0, weight = 0;
};

/// Returns the rule of N nodes, in ascending order, which is exact for polynomials of degrees below 2 N. Each node is a root
/// of the Legendre polynomial of degree N, found by Newton's method.
template <std::size_t N>
std::array<QuadratureNode, N> gauss_legendre()
{
    std::array<QuadratureNode, N> nodes;
    for (std::size_t i = 0; i < N; ++i) {
        // Roots lie close to Chebyshev's, one by one.
        double root = -std::cos(3.14159265358979323846 * (double(i) + 0.75) / (double(N) + 0.5)), slope = 1;
        for (int step = 0; step < 8; ++step) {
            double value = 1, before = 0;
            for (std::size_t k = 1; k <= N; ++k) {
                const double next = (double(2 * k - 1) * root * value - double(k - 1) * before) / double(k);
                before = value;
                value = next;
            }
            slope = double(N) * (root * value - before) / (root * root - 1);
            root -= value / slope;
        }
        nodes[i] = {(root + 1) / 2, 1 / ((1 - root * root) * slope * slope)};
    }
    return nodes;
}

}  // namespace occam::shade
