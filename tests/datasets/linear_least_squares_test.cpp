// Linear least squares against the certified values of NIST's Statistical Reference Datasets. Files
// of others are read from outside the repository. The five of Wampler are made here, because they
// follow from the third: their polynomials are whole numbers, and their errors multiples of each
// other.
#include "datasets/statistics/linear_least_squares.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "tests/support/certified_digits.h"
#include "tests/support/read_rows.h"

namespace graintruth::datasets {
namespace {

using tests::digits;

constexpr int degree_of_wampler = 5, points_of_wampler = 21;

Eigen::MatrixXd powers(const Eigen::VectorXd& x, int degree) {
  Eigen::MatrixXd design(x.size(), degree + 1);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    for (int power = 0; power <= degree; ++power) design(i, power) = std::pow(x[i], power);
  }
  return design;
}

// What Wampler added to a polynomial of the fifth degree: at right angles on every column.
constexpr std::array<double, points_of_wampler> wampler_errors = {
    759,   -2048, 2048,  -2048, 2523,  -2048, 2048,  -2048, 1838,  -2048, 2048,
    -2048, 1838,  -2048, 2048,  -2048, 2523,  -2048, 2048,  -2048, 759};

struct Worst {
  double parameters = 11.0, standard_errors = 11.0;
};

// base: y = sum (base x)^k, as whole numbers or decimal fractions.
Worst wampler(double base, double error, double certified_error) {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(points_of_wampler, 0.0, 20.0);
  Eigen::VectorXd y(points_of_wampler);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    long double sum = 0.0L;
    for (int power = degree_of_wampler; power >= 0; --power)
      sum = sum * (base == 1.0 ? x[i] : static_cast<long double>(x[i]) / 10.0L) + 1.0L;
    y[i] = static_cast<double>(sum) + error * wampler_errors[static_cast<std::size_t>(i)];
  }
  const LinearFit fit = linear_least_squares(powers(x, degree_of_wampler), y);
  EXPECT_TRUE(fit.is_determined);
  Worst worst;
  for (int k = 0; k <= degree_of_wampler; ++k)
    worst.parameters = std::min(worst.parameters, digits(fit.parameters[k], std::pow(base, k)));
  worst.standard_errors = digits(fit.standard_error(degree_of_wampler), certified_error);
  return worst;
}

// Certified of Wampler3: the standard error of B5 is 0.112324854679312
TEST(LinearLeastSquares, FitsWamplersPolynomialsWhateverTheirErrors) {
  constexpr double of_third = 0.112324854679312;
  for (const double error : {1.0, 100.0, 10000.0}) {
    const Worst worst = wampler(1.0, error, error * of_third);
    EXPECT_GE(worst.parameters, 9.0) << error;
    EXPECT_GE(worst.standard_errors, 9.0) << error;
  }
  EXPECT_GE(wampler(1.0, 0.0, 0.0).parameters, 9.0);
  EXPECT_GE(wampler(0.1, 0.0, 0.0).parameters, 9.0);
}

// Longley (1967), of the American economy: columns that all grow alike.
constexpr double longley[16][7] = {{60323, 83.0, 234289, 2356, 1590, 107608, 1947},
                                   {61122, 88.5, 259426, 2325, 1456, 108632, 1948},
                                   {60171, 88.2, 258054, 3682, 1616, 109773, 1949},
                                   {61187, 89.5, 284599, 3351, 1650, 110929, 1950},
                                   {63221, 96.2, 328975, 2099, 3099, 112075, 1951},
                                   {63639, 98.1, 346999, 1932, 3594, 113270, 1952},
                                   {64989, 99.0, 365385, 1870, 3547, 115094, 1953},
                                   {63761, 100.0, 363112, 3578, 3350, 116219, 1954},
                                   {66019, 101.2, 397469, 2904, 3048, 117388, 1955},
                                   {67857, 104.6, 419180, 2822, 2857, 118734, 1956},
                                   {68169, 108.4, 442769, 2936, 2798, 120445, 1957},
                                   {66513, 110.8, 444546, 4681, 2637, 121950, 1958},
                                   {68655, 112.6, 482704, 3813, 2552, 123366, 1959},
                                   {69564, 114.2, 502601, 3931, 2514, 125368, 1960},
                                   {69331, 115.7, 518173, 4806, 2572, 127852, 1961},
                                   {70551, 116.9, 554894, 4007, 2827, 130081, 1962}};
constexpr double certified_longley[7] = {-3482258.63459582,
                                         15.0618722713733,
                                         -0.0358191792925910,
                                         -2.02022980381683,
                                         -1.03322686717359,
                                         -0.0511041056535807,
                                         1829.15146461355};

TEST(LinearLeastSquares, FitsLongleysEconomy) {
  Eigen::MatrixXd design(16, 7);
  Eigen::VectorXd values(16);
  for (Eigen::Index i = 0; i < 16; ++i) {
    values[i] = longley[i][0];
    design(i, 0) = 1.0;
    for (Eigen::Index j = 1; j < 7; ++j) design(i, j) = longley[i][j];
  }
  const LinearFit fit = linear_least_squares(design, values);
  EXPECT_TRUE(fit.is_determined);
  for (Eigen::Index j = 0; j < 7; ++j)
    EXPECT_GE(digits(fit.parameters[j], certified_longley[j]), 11.0) << j;
}

// A polynomial of the tenth degree far from 0, as NIST's Filip is: its columns differ in the tenth
// digit only. Certified by rational numbers.
TEST(LinearLeastSquares, FitsAPolynomialOfTheTenthDegreeFarFromZero) {
  constexpr std::array<double, 11> certified = {-1.97366960522869030e+2,
                                                -3.70433687248343941e+2,
                                                -3.06842637517892143e+2,
                                                -1.48348501294753213e+2,
                                                -4.63708577151419811e+1,
                                                -9.79544441205557326e+0,
                                                -1.41673292161946548e+0,
                                                -1.38591075162519896e-1,
                                                -8.78009425760151191e-3,
                                                -3.25449068209523288e-4,
                                                -5.36246675651446412e-6};
  Eigen::VectorXd x(82), y(82);
  for (int i = 0; i < 82; ++i) {
    x[i] = -(310 + 7 * i) / 100.0;
    y[i] = (8000 + (37 * i * i + 11 * i * i * i) % 60) / 10000.0;
  }
  const LinearFit fit = linear_least_squares(powers(x, 10), y);
  EXPECT_TRUE(fit.is_determined);
  for (int k = 0; k <= 10; ++k)
    EXPECT_GE(digits(fit.parameters[k], certified[static_cast<std::size_t>(k)]), 7.0) << k;
}

// y and x of a file of NIST, which begin in line 61, and its certified parameters.
struct NistLine {
  Eigen::VectorXd x, y;
  std::vector<double> parameters, standard_errors;
};
NistLine read_nist(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<double> x, y;
  NistLine read;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::istringstream cells(line);
    std::string name;
    double first = 0.0, second = 0.0;
    if (number <= 60) {
      if (cells >> name >> first >> second && name.size() == 2 && name[0] == 'B') {
        read.parameters.push_back(first);
        read.standard_errors.push_back(second);
      }
    } else if (cells >> first >> second) {
      y.push_back(first);
      x.push_back(second);
    }
  }
  read.x = Eigen::Map<Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
  read.y = Eigen::Map<Eigen::VectorXd>(y.data(), static_cast<Eigen::Index>(y.size()));
  return read;
}

TEST(LinearLeastSquares, FitsNistsFiles) {
  const auto folder = tests::outside_reference("nist_strd/linear");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
  for (const auto& [name, degree] : {std::pair("Norris", 1),
                                     std::pair("Wampler1", 5),
                                     std::pair("Wampler3", 5),
                                     std::pair("NoInt1", 1)}) {
    const NistLine nist = read_nist(folder / (std::string(name) + ".dat"));
    Eigen::MatrixXd design = powers(nist.x, degree);
    if (std::string(name) == "NoInt1") design = Eigen::MatrixXd(nist.x);
    ASSERT_EQ(static_cast<std::size_t>(design.cols()), nist.parameters.size()) << name;
    const LinearFit fit = linear_least_squares(design, nist.y);
    for (int k = 0; k < design.cols(); ++k) {
      const auto at = static_cast<std::size_t>(k);
      EXPECT_GE(digits(fit.parameters[k], nist.parameters[at]), 9.0) << name << k;
      if (nist.standard_errors[at] > 0.0) {
        EXPECT_GE(digits(fit.standard_error(k), nist.standard_errors[at]), 9.0) << name << k;
      }
    }
  }
}

// Known errors weigh, and are not scaled by what scatters.
TEST(LinearLeastSquares, WeighsByUncertainties) {
  const Eigen::MatrixXd ones = Eigen::MatrixXd::Ones(3, 1);
  const LinearFit fit =
      linear_least_squares(ones, Eigen::Vector3d(1.0, 2.0, 6.0), std::array{1.0, 1.0, 0.5});
  // Weights 1, 1, 4
  EXPECT_NEAR(fit.parameters[0], 27.0 / 6.0, 1e-14);
  EXPECT_NEAR(fit.standard_error(0), 1.0 / std::sqrt(6.0), 1e-14);
  for (const double bad : {0.0,
                           -1.0,
                           std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(
        linear_least_squares(ones, Eigen::Vector3d(1.0, 2.0, 6.0), std::array{1.0, bad, 0.5}),
        std::invalid_argument);
  }
}

TEST(LinearLeastSquares, SaysWhatColumnsDoNotDetermine) {
  Eigen::MatrixXd design(4, 2);
  design << 1, 1e9, 2, 2e9, 3, 3e9, 4, 4e9;
  const LinearFit fit = linear_least_squares(design, Eigen::Vector4d(1.0, 2.0, 3.0, 4.5));
  EXPECT_FALSE(fit.is_determined);
  EXPECT_TRUE(std::isnan(fit.standard_error(0)));
}

TEST(LinearLeastSquares, AStraightLineIsTheSameByDifferences) {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(9, 1e6, 1e6 + 8.0);
  Eigen::VectorXd y = 3.0 + 0.5 * x.array() + 0.1 * (3.0 * x.array()).sin();
  const StraightLine line = straight_line(std::span(x.data(), 9), std::span(y.data(), 9));
  const LinearFit fit = linear_least_squares(powers(x, 1), y);
  EXPECT_NEAR(line.slope, fit.parameters[1], 1e-10);
  EXPECT_NEAR(line.intercept, fit.parameters[0], 1e-4);
  EXPECT_NEAR(line.slope_standard_error(9), fit.standard_error(1), 1e-10);
  EXPECT_NEAR(line.sum_of_squares, fit.sum_of_squares, 1e-9);
}

}  // namespace
}  // namespace graintruth::datasets
