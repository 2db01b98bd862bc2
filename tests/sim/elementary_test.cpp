// The simulator's own mathematical functions against MPFR, bit by bit.
#include "sim/laws/elementary.h"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>
#include <functional>

namespace graintruth::sim {
namespace {

class Exact {
 public:
  Exact() { mpfr_init2(value_, 300); }
  explicit Exact(double x) : Exact() { mpfr_set_d(value_, x, MPFR_RNDN); }
  ~Exact() { mpfr_clear(value_); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;
  double rounded() const { return mpfr_get_d(value_, MPFR_RNDN); }
  mpfr_ptr get() { return value_; }

 private:
  mpfr_t value_;
};

using OfOne = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);

double by_mpfr(OfOne function, double x) {
  Exact input(x), output;
  function(output.get(), input.get(), MPFR_RNDN);
  return output.rounded();
}

constexpr int tries = 5000;

struct Function {
  const char* name;
  double (*own)(double);
  OfOne mpfr;
  double low, high;
};

class OfOneArgument : public testing::TestWithParam<Function> {};

TEST_P(OfOneArgument, IsCorrectlyRounded) {
  const auto& [name, own, mpfr, low, high] = GetParam();
  boost::random::mt19937_64 generator(1);
  boost::random::uniform_real_distribution<double> all(low, high), exponent(-60.0, 0.0);
  for (int i = 0; i < tries; ++i) {
    // Over the range, and near its zero
    double x = all(generator);
    if (i % 2 == 1) x *= std::ldexp(1.0, static_cast<int>(exponent(generator)));
    if (x <= low) continue;
    ASSERT_EQ(own(x), by_mpfr(mpfr, x)) << name << " of " << std::hexfloat << x;
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         OfOneArgument,
                         testing::Values(Function{"exp", exact_exp, mpfr_exp, -690.0, 700.0},
                                         Function{"log", exact_log, mpfr_log, 0.0, 1e5},
                                         Function{"log1p", exact_log1p, mpfr_log1p, -1.0, 3.0},
                                         Function{"cbrt", exact_cbrt, mpfr_cbrt, -1e5, 1e5},
                                         Function{"erf", exact_erf, mpfr_erf, -5.0, 5.0}),
                         [](const auto& one) { return std::string(one.param.name); });

// Units in the last place of the right value.
double units_off(double value, double right) {
  const double size = std::abs(right);
  return std::abs(value - right) / (std::nextafter(size, 2.0 * size) - size);
}

TEST(Steady, AreWithinAFewUnitsInTheLastPlace) {
  boost::random::mt19937_64 generator(3);
  for (const auto& [name, own, mpfr, low, high] :
       {Function{"sin", steady_sin, mpfr_sin, -1e6, 1e6},
        Function{"cos", steady_cos, mpfr_cos, -1e6, 1e6},
        Function{"sin of a turn", steady_sin, mpfr_sin, -7.0, 7.0},
        Function{"cos of a turn", steady_cos, mpfr_cos, -7.0, 7.0},
        Function{"tan", steady_tan, mpfr_tan, -1.5, 1.5},
        Function{"asin", steady_asin, mpfr_asin, -1.0, 1.0},
        Function{"acos", steady_acos, mpfr_acos, -1.0, 1.0}}) {
    boost::random::uniform_real_distribution<double> all(low, high), exponent(-60.0, 0.0);
    const double allowed = name[0] == 'a' || name[0] == 't' ? 4.0 : 2.0;
    for (int i = 0; i < tries; ++i) {
      double x = all(generator);
      if (i % 2 == 1) x *= std::ldexp(1.0, static_cast<int>(exponent(generator)));
      ASSERT_LE(units_off(own(x), by_mpfr(mpfr, x)), allowed) << name << " of " << x;
    }
  }
}

TEST(OfTwoArguments, AreRight) {
  boost::random::mt19937_64 generator(2);
  boost::random::uniform_real_distribution<double> part(-1.0, 1.0), base(0.0, 1e3),
      power(-6.0, 6.0);
  for (int i = 0; i < tries; ++i) {
    const double y = part(generator) * (i % 3 == 0 ? 1e-9 : 1.0), x = part(generator);
    Exact py(y), px(x), angle;
    mpfr_atan2(angle.get(), py.get(), px.get(), MPFR_RNDN);
    ASSERT_LE(units_off(steady_atan2(y, x), angle.rounded()), 4.0)
        << std::hexfloat << y << ' ' << x;
    const double b = base(generator), e = power(generator);
    Exact pb(b), pe(e), result;
    mpfr_pow(result.get(), pb.get(), pe.get(), MPFR_RNDN);
    ASSERT_EQ(exact_pow(b, e), result.rounded()) << std::hexfloat << b << ' ' << e;
  }
}

TEST(OwnFunctions, GiveWhatEveryoneKnows) {
  EXPECT_EQ(exact_exp(0.0), 1.0);
  EXPECT_EQ(exact_log(1.0), 0.0);
  EXPECT_EQ(exact_pow(4.0, 0.5), 2.0);
  EXPECT_EQ(exact_pow(0.0, 0.4), 0.0);
  EXPECT_EQ(exact_cbrt(27.0), 3.0);
  EXPECT_EQ(exact_cbrt(-1e-9), -1e-3);
  EXPECT_EQ(steady_sin(0.0), 0.0);
  EXPECT_EQ(steady_cos(0.0), 1.0);
  EXPECT_EQ(steady_atan2(0.0, 1.0), 0.0);
  EXPECT_EQ(steady_atan2(0.0, -1.0), std::atan2(0.0, -1.0));
  EXPECT_EQ(steady_atan2(-0.0, -1.0), std::atan2(-0.0, -1.0));
  EXPECT_EQ(steady_atan2(1.0, 0.0), std::atan2(1.0, 0.0));
  EXPECT_EQ(steady_atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(steady_acos(1.0), 0.0);
  EXPECT_EQ(steady_acos(-1.0), std::acos(-1.0));
  EXPECT_EQ(steady_asin(1.0), std::asin(1.0));
  EXPECT_EQ(steady_atan2(1e-150, -1e-150), std::atan2(1.0, -1.0));
}

}  // namespace
}  // namespace graintruth::sim
