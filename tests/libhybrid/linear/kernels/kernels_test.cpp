// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/kernels/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;
using Array = std::vector<double>;

Array random_array(std::size_t size, Random& random) {
  Array array(size);
  for (double& x : array) x = random.normal();
  return array;
}

/// A panel of `height` rows whose first `columns` have dominant diagonals.
Array random_panel(int height, int columns, Random& random) {
  const int stride = height + kRowPadding;
  Array panel = random_array(std::size_t(stride) * columns + kPacket, random);
  for (int c = 0; c < columns; ++c) panel[c * (stride + 1)] = 4.0 * height + c;
  return panel;
}

bool same_bits(const Array& a, const Array& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Runs `make`, which returns all that a kernel computes, with each set that the processor has.
template <class Make>
void expect_same_bits(const Make& make) {
  const Array expected = make(*supported_kernels().front());
  for (const Kernels* kernels : supported_kernels()) {
    SCOPED_TRACE(kernels->name);
    EXPECT_TRUE(same_bits(make(*kernels), expected));
  }
}

template <class Make>
void for_all_panels(const Make& make) {
  Random random(7);
  for (int columns : {1, 2, 3, 4, 5, 6, 7, 8, 12, 18, 23}) {
    for (int below : {0, 1, 2, 3, 6, 8, 13, 24, 41}) {
      SCOPED_TRACE(std::to_string(columns) + " columns, " + std::to_string(below) + " below");
      const Array panel = random_panel(columns + below, columns, random);
      expect_same_bits(
          [&](const Kernels& kernels) { return make(kernels, panel, columns, below); });
    }
  }
}

TEST(DenseKernels, TheWidestOfThoseSupportedAreUsed) {
  ASSERT_FALSE(supported_kernels().empty());
  EXPECT_EQ(std::string(supported_kernels().front()->name), "baseline");
  EXPECT_EQ(&kernels(), supported_kernels().back());
}

TEST(DenseKernels, AllSetsGiveTheSameDotProduct) {
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Array a = random_array(n, random), b = random_array(n, random);
    expect_same_bits(
        [&](const Kernels& kernels) { return Array{kernels.dot(a.data(), b.data(), n)}; });
  }
}

TEST(DenseKernels, AllSetsGiveTheSameFront) {
  Random random(2);
  for (int n = 1; n <= 70; ++n) {
    Array lower = random_array(std::size_t(n) * n, random);
    for (int j = 0; j < n; ++j) lower[j * (n + 1)] = j % 5 == 4 ? -1.0 : 2.0 * n;
    const Array least(n, 0.5);
    for (int f : {1, n / 2, n}) {
      if (f < 1) continue;
      for (bool lift : {false, true}) {
        SCOPED_TRACE("order " + std::to_string(n) + ", eliminating " + std::to_string(f));
        expect_same_bits([&](const Kernels& kernels) {
          const int stride = round_up(n + kernels.front_padding);
          Array front(std::size_t(stride) * (n + 4), 0.0);
          for (int j = 0; j < n; ++j) {
            for (int i = j; i < n; ++i) front[std::size_t(j) * stride + i] = lower[j * n + i];
          }
          std::vector<int> lifted(f, -1);
          Pivots pivots{least.data(), lift ? lifted.data() : nullptr, 0};
          Array result = {double(kernels.eliminate(front.data(), n, stride, f, pivots)),
                          double(pivots.lifted_count)};
          result.insert(result.end(), lifted.begin(), lifted.end());
          for (int j = 0; j < n; ++j) {
            const double* column = front.data() + std::size_t(j) * stride;
            result.insert(result.end(), column + j, column + n);
          }
          return result;
        });
      }
    }
  }
}

TEST(DenseKernels, AllSetsGiveTheSamePanelAndUpdate) {
  for_all_panels([](const Kernels& kernels, Array panel, int columns, int below) {
    const int height = columns + below, stride = height + kRowPadding, size = round_up(below);
    Array result = {double(kernels.factorize_panel(panel.data(), stride, height, columns))};
    Array update(std::size_t(size) * size, 0.0);
    kernels.update_columns(panel.data(), stride, columns, update.data(), size, 0, size);
    for (int c = 0; c < columns; ++c) {
      const double* column = panel.data() + std::size_t(c) * stride;
      result.insert(result.end(), column + c, column + height);
    }
    for (int c = 0; c < below; ++c) {
      const double* column = update.data() + std::size_t(c) * size;
      result.insert(result.end(), column + c, column + below);
    }
    return result;
  });
}

TEST(DenseKernels, AllSetsEndAtTheSamePivot) {
  Random random(3);
  for (int columns = 1; columns < 12; ++columns) {
    const int bad = random.below(columns), height = columns + 5, stride = height + kRowPadding;
    Array panel = random_panel(height, columns, random);
    panel[bad * (stride + 1)] = -1.0;
    for (const Kernels* kernels : supported_kernels()) {
      Array copy = panel;
      EXPECT_EQ(kernels->factorize_panel(copy.data(), stride, height, columns), bad)
          << kernels->name;
    }
  }
}

TEST(DenseKernels, AllSetsGiveTheSameInverse) {
  for_all_panels([](const Kernels& kernels, const Array& panel, int columns, int below) {
    const int stride = columns + below + kRowPadding;
    const std::size_t wide = round_up(columns), tall = round_up(below);
    Array inverse(wide * wide), own(wide * wide), gain(wide * (tall + 1)), coupling(gain.size());
    Array below_inverse(tall * tall), out(panel.size());
    for (int c = 0; c < below; ++c) {
      for (int r = 0; r < below; ++r) below_inverse[c * tall + r] = 1.0 / (1 + c + r);
    }
    kernels.invert_panel({panel.data(), stride, columns, below, below_inverse.data(),
                          inverse.data(), own.data(), gain.data(), coupling.data(), out.data()});
    return out;
  });
}

TEST(DenseKernels, AllSetsGiveTheSameSubstitution) {
  for_all_panels([](const Kernels& kernels, const Array& panel, int columns, int below) {
    const int height = columns + below, stride = height + kRowPadding;
    Array inverse_diagonal;
    for (int c = 0; c < columns; ++c) inverse_diagonal.push_back(1.0 / panel[c * (stride + 1)]);
    Array x(stride, 0.0);
    for (int r = 0; r < height; ++r) x[r] = 1.0 + r / 3.0;
    kernels.forward(panel.data(), stride, height, columns, inverse_diagonal.data(), x.data());
    Array result(x.begin(), x.begin() + height);
    std::fill(x.begin() + height, x.end(), 0.0);
    kernels.backward(panel.data(), stride, height, columns, inverse_diagonal.data(), x.data());
    result.insert(result.end(), x.begin(), x.begin() + height);
    return result;
  });
}

}  // namespace
}  // namespace hybrid
