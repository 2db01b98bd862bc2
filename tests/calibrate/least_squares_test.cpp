// The fitter against the certified values of NIST's Statistical Reference Datasets, non-linear
// regression. The files are others' and are read from outside the repository.
#include "calibrate/search/least_squares.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <numbers>
#include <sstream>

#include "tests/support/certified_digits.h"
#include "tests/support/read_rows.h"

namespace graintruth::calibrate {
namespace {

using Vector = Eigen::VectorXd;
using Model = double (*)(const Vector& b, const std::vector<double>& x);

constexpr double pi = std::numbers::pi;

double two_peaks(const Vector& b, const std::vector<double>& x) {
  return b[0] * std::exp(-b[1] * x[0]) + b[2] * std::exp(-std::pow((x[0] - b[3]) / b[4], 2)) +
         b[5] * std::exp(-std::pow((x[0] - b[6]) / b[7], 2));
}
double chwirut(const Vector& b, const std::vector<double>& x) {
  return std::exp(-b[0] * x[0]) / (b[1] + b[2] * x[0]);
}
double saturating(const Vector& b, const std::vector<double>& x) {
  return b[0] * (1.0 - std::exp(-b[1] * x[0]));
}

// The models as the files state them.
const std::map<std::string, Model> models = {
    {"Misra1a", saturating},
    {"BoxBOD", saturating},
    {"Misra1b",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] * (1.0 - std::pow(1.0 + b[1] * x[0] / 2.0, -2.0));
     }},
    {"Misra1c",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] * (1.0 - std::pow(1.0 + 2.0 * b[1] * x[0], -0.5));
     }},
    {"Misra1d",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] * b[1] * x[0] / (1.0 + b[1] * x[0]);
     }},
    {"Chwirut1", chwirut},
    {"Chwirut2", chwirut},
    {"DanWood",
     [](const Vector& b, const std::vector<double>& x) { return b[0] * std::pow(x[0], b[1]); }},
    {"ENSO",
     [](const Vector& b, const std::vector<double>& x) {
       const double t = 2.0 * pi * x[0];
       return b[0] + b[1] * std::cos(t / 12.0) + b[2] * std::sin(t / 12.0) +
              b[4] * std::cos(t / b[3]) + b[5] * std::sin(t / b[3]) + b[7] * std::cos(t / b[6]) +
              b[8] * std::sin(t / b[6]);
     }},
    {"Gauss1", two_peaks},
    {"Gauss2", two_peaks},
    {"Kirby2",
     [](const Vector& b, const std::vector<double>& x) {
       const double t = x[0];
       return (b[0] + t * (b[1] + t * b[2])) / (1.0 + t * (b[3] + t * b[4]));
     }},
    {"Lanczos3",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] * std::exp(-b[1] * x[0]) + b[2] * std::exp(-b[3] * x[0]) +
              b[4] * std::exp(-b[5] * x[0]);
     }},
    {"MGH17",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] + b[1] * std::exp(-x[0] * b[3]) + b[2] * std::exp(-x[0] * b[4]);
     }},
    {"Nelson",  // of the logarithm of the response
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] - b[1] * x[0] * std::exp(-b[2] * x[1]);
     }},
    {"Roszman1",
     [](const Vector& b, const std::vector<double>& x) {
       return b[0] - b[1] * x[0] - std::atan(b[2] / (x[0] - b[3])) / pi;
     }},
    {"Thurber",
     [](const Vector& b, const std::vector<double>& x) {
       const double t = x[0];
       return (b[0] + t * (b[1] + t * (b[2] + t * b[3]))) /
              (1.0 + t * (b[4] + t * (b[5] + t * b[6])));
     }},
};

struct Certified {
  std::array<std::vector<double>, 2> starts;
  std::vector<double> parameters, standard_errors;
  std::vector<double> response;
  std::vector<std::vector<double>> predictors;
};

// Parameters stand in lines "bN = start start certified error"; "Data (lines A to B)" tells where
// the rows y x ... are.
Certified read_certified(const std::filesystem::path& file, bool log_response) {
  Certified result;
  std::ifstream stream(file);
  int first = 0, last = 0, number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    int from = 0, to = 0;
    const auto where = line.find("Data   ");
    if (where != std::string::npos && line.find("(lines") != std::string::npos &&
        std::sscanf(line.c_str() + line.find("(lines"), "(lines %d to %d)", &from, &to) == 2) {
      first = from;
      last = to;
    }
    int index = 0;
    double one = 0.0, two = 0.0, certified = 0.0, error = 0.0;
    if (std::sscanf(
            line.c_str(), " b%d = %lf %lf %lf %lf", &index, &one, &two, &certified, &error) == 5) {
      result.starts[0].push_back(one);
      result.starts[1].push_back(two);
      result.parameters.push_back(certified);
      result.standard_errors.push_back(error);
    }
    if (first == 0 || number < first || number > last) continue;
    std::istringstream cells(line);
    double y = 0.0;
    if (!(cells >> y)) continue;
    result.response.push_back(log_response ? std::log(y) : y);
    std::vector<double> x;
    for (double value = 0.0; cells >> value;) x.push_back(value);
    result.predictors.push_back(x);
  }
  return result;
}

using tests::digits;

struct Score {
  double parameters = 11.0, standard_errors = 11.0;
  bool converged = false;
};

Score score_from(const Certified& certified, Model model, int start) {
  const auto residuals = [&](const Vector& b) {
    Vector result(static_cast<Eigen::Index>(certified.response.size()));
    for (std::size_t i = 0; i < certified.response.size(); ++i)
      result[static_cast<Eigen::Index>(i)] =
          certified.response[i] - model(b, certified.predictors[i]);
    return result;
  };
  const std::vector<double>& from = certified.starts[static_cast<std::size_t>(start)];
  const LeastSquaresFit fit = fit_least_squares(
      residuals, Eigen::Map<const Vector>(from.data(), static_cast<Eigen::Index>(from.size())));
  Score score;
  score.converged = fit.converged;
  for (int i = 0; i < fit.parameters.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    score.parameters =
        std::min(score.parameters, digits(fit.parameters[i], certified.parameters[k]));
    score.standard_errors = std::min(score.standard_errors,
                                     digits(fit.standard_error(i), certified.standard_errors[k]));
  }
  return score;
}

class NistNonlinear : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = tests::outside_reference("nist_strd/nonlinear");
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << folder_ << " is not here";
  }
  Certified read(const std::string& name) const {
    return read_certified(folder_ / (name + ".dat"), name == "Nelson");
  }
  std::filesystem::path folder_;
};

TEST_F(NistNonlinear, FromTheSecondStartAllAreCertifiedDigits) {
  double sum = 0.0;
  for (const auto& [name, model] : models) {
    const Score score = score_from(read(name), model, 1);
    EXPECT_TRUE(score.converged) << name;
    EXPECT_GE(score.parameters, 6.0) << name;
    EXPECT_GE(score.standard_errors, 5.0) << name;
    sum += score.parameters;
  }
  const double mean = sum / static_cast<double>(models.size());
  RecordProperty("mean_digits", std::to_string(mean));
  std::cout << "mean digits from start 2: " << mean << '\n';
  EXPECT_GE(mean, 9.4);
}

TEST_F(NistNonlinear, FromTheFarStartMostAreAndNoneLies) {
  int right = 0;
  for (const auto& [name, model] : models) {
    const Score score = score_from(read(name), model, 0);
    if (score.parameters >= 4.0) {
      ++right;
    } else {
      std::cout << name << ": " << score.parameters << " digits from start 1, "
                << (score.converged ? "converged elsewhere" : "said so") << '\n';
    }
  }
  EXPECT_GE(right, 15);
}

// A law that is linear in its parameters is found to be, from whatever start. NIST certifies 1 for
// all parameters, and these standard errors of the first and the last.
TEST(LeastSquares, ALinearLawHasItsAnswerAtOnce) {
  constexpr std::array<double, 21> errors = {759,   -2048, 2048,  -2048, 2523,  -2048, 2048,
                                             -2048, 1838,  -2048, 2048,  -2048, 1838,  -2048,
                                             2048,  -2048, 2523,  -2048, 2048,  -2048, 759};
  for (const double size : {1.0, 1e4}) {
    const auto residuals = [&](const Vector& b) {
      Vector result(21);
      for (int i = 0; i < 21; ++i) {
        double y = size * errors[static_cast<std::size_t>(i)], law = 0.0;
        for (int power = 5; power >= 0; --power) law = law * i + b[power];
        for (int power = 0; power <= 5; ++power) y += std::pow(i, power);
        result[i] = y - law;
      }
      return result;
    };
    for (const double start : {0.0, 3.0}) {
      const LeastSquaresFit fit = fit_least_squares(residuals, Vector::Constant(6, start));
      EXPECT_TRUE(fit.converged);
      for (int k = 0; k < 6; ++k) EXPECT_GE(digits(fit.parameters[k], 1.0), 9.0) << k;
      EXPECT_GE(digits(fit.standard_error(0), size * 2152.32624678170), 9.0);
      EXPECT_GE(digits(fit.standard_error(5), size * 0.112324854679312), 9.0);
    }
  }
}

// A polynomial of the tenth degree far from 0, certified by rational numbers: the first and the
// last of eleven parameters.
TEST(LeastSquares, ALinearLawMayBeIllConditioned) {
  const auto residuals = [](const Vector& b) {
    Vector result(82);
    for (int i = 0; i < 82; ++i) {
      const double x = -(310 + 7 * i) / 100.0;
      result[i] = (8000 + (37 * i * i + 11 * i * i * i) % 60) / 10000.0;
      for (int power = 0; power <= 10; ++power) result[i] -= b[power] * std::pow(x, power);
    }
    return result;
  };
  const LeastSquaresFit fit = fit_least_squares(residuals, Vector::Constant(11, 1.0));
  EXPECT_TRUE(fit.converged);
  EXPECT_GE(digits(fit.parameters[0], -1.97366960522869030e+2), 7.0);
  EXPECT_GE(digits(fit.parameters[10], -5.36246675651446412e-6), 7.0);
}

TEST(LeastSquares, KnownErrorsAreNotRescaled) {
  // A mean of n values with known error s: standard error s / sqrt(n), whatever the scatter
  const std::vector<double> values = {1.0, 5.0, 3.0, 7.0};
  const auto residuals = [&](const Vector& b) {
    Vector result(4);
    for (int i = 0; i < 4; ++i) result[i] = (values[static_cast<std::size_t>(i)] - b[0]) / 0.5;
    return result;
  };
  const LeastSquaresFit fit =
      fit_least_squares(residuals, Vector::Constant(1, 1.0), ResidualScale::known);
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.parameters[0], 4.0, 1e-10);
  EXPECT_NEAR(fit.standard_error(0), 0.25, 1e-10);
  EXPECT_NEAR(fit.half_width_95(0), 0.25 * 1.959964, 1e-6);
}

TEST(LeastSquares, SaysWhenItHasNotConverged) {
  // exp(-b) has no least value
  const auto residuals = [](const Vector& b) {
    return Vector(Vector::Constant(3, 1.0 + std::exp(-b[0])));
  };
  EXPECT_FALSE(fit_least_squares(residuals, Vector::Constant(1, 1.0)).converged);
}

}  // namespace
}  // namespace graintruth::calibrate
