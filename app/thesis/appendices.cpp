// Appendices D and E from printed data: what the decks say of themselves, and the deviation of the
// contact normal of the model button.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/thesis/button.h"
#include "app/thesis/targets.h"
#include "datasets/statistics/linear_least_squares.h"
#include "sim/shapes/clump.h"
#include "sim/shapes/surface_error.h"

namespace graintruth::app {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

struct DeckSpheres {
  std::vector<double> radius, place;  // cm; place on the axis with its sign
};

DeckSpheres spheres_of(const ThesisData& thesis, const std::string& deck) {
  const datasets::Table& table = thesis.table("deck_spheres");
  DeckSpheres spheres;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.text(row, "deck") != deck) continue;
    const std::string& place = table.text(row, "axial_coordinate_cm_sign_inferred");
    spheres.radius.push_back(table.number(row, "radius_cm"));
    spheres.place.push_back(Printed{place.substr(place.starts_with('+') ? 1 : 0)}.value());
  }
  return spheres;
}

// Where the centroid of the union lies, cm.
double centroid_of(const DeckSpheres& spheres) {
  std::vector<sim::ElementSphere> elements;
  for (std::size_t i = 0; i < spheres.radius.size(); ++i) {
    elements.push_back({sim::Vec3(spheres.place[i], 0.0, 0.0), spheres.radius[i]});
  }
  return sim::mass_properties_of_union(elements).centre.x();
}

// Least squares of the radius on the place, without the spheres (from 1) that do not fit.
datasets::StraightLine taper(const DeckSpheres& spheres,
                             std::size_t left_out,
                             std::size_t also_left_out) {
  std::vector<double> places, radii;
  for (std::size_t i = 0; i < spheres.radius.size(); ++i) {
    if (i + 1 == left_out || i + 1 == also_left_out) continue;
    places.push_back(spheres.place[i]);
    radii.push_back(spheres.radius[i]);
  }
  return datasets::straight_line(places, radii);
}

void examine_start(Examination& exam, const ThesisData& thesis) {
  const std::string name = "deck_start";
  const datasets::Table& table = thesis.table(name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string deck = table.text(row, "deck") + ": ";
    exam.compare(
        deck + "nballm = npar x ntype + nwall",
        thesis.cell(name, row, "nballm", "-"),
        table.number(row, "npar") * table.number(row, "ntype") + table.number(row, "nwall"));
    const double edge = std::cbrt(table.number(row, "xdim_cm") * table.number(row, "ydim_cm") *
                                  table.number(row, "zdim_cm") / table.number(row, "nbox"));
    exam.compare(deck + "edge of a cell", thesis.cell(name, row, "cell_edge_cm", "cm"), edge);
    // Section 2.5.5: a cell is at least as large as the largest sphere
    const double share = edge / table.number(row, "largest_sphere_diameter_cm");
    if (share < 1.0) exam.compare_worded(deck + "edge of a cell over the largest diameter", share);
  }
}

}  // namespace

void examine_decks(Examination& exam, const ThesisData& thesis) {
  examine_start(exam, thesis);

  // The taper of the conical particle; the places of spheres 7 and 14 do not fit it
  const DeckSpheres cone = spheres_of(thesis, "D_a_conical_single");
  exam.compare_worded("deck (a): element spheres of the conical particle",
                      static_cast<double>(cone.radius.size()));
  constexpr std::size_t seventh = 7, fourteenth = 14;
  const datasets::StraightLine line = taper(cone, seventh, fourteenth);
  for (const std::size_t sphere : {seventh, fourteenth}) {
    exam.compare_worded(fmt::format("deck (a): place of sphere {}", sphere),
                        (cone.radius[sphere - 1] - line.intercept) / line.slope);
  }
  for (const auto& [letter, deck] : {std::pair{"a", "D_a_conical_single"},
                                     std::pair{"b", "D_b_irregular_single"},
                                     std::pair{"c", "D_c_conical_bunch"}}) {
    exam.compare_worded(fmt::format("deck ({}): centroid of the union", letter),
                        centroid_of(spheres_of(thesis, deck)));
  }
  const DeckSpheres ellipsoid = spheres_of(thesis, "D_d_singulation");
  double left = 0.0, right = 0.0, widest = 0.0;
  for (std::size_t i = 0; i < ellipsoid.radius.size(); ++i) {
    left = std::min(left, ellipsoid.place[i] - ellipsoid.radius[i]);
    right = std::max(right, ellipsoid.place[i] + ellipsoid.radius[i]);
    widest = std::max(widest, 2.0 * ellipsoid.radius[i]);
  }
  exam.compare_worded("deck (d): aspect ratio", (right - left) / widest);
  const datasets::Table& start = thesis.table("deck_start");
  for (std::size_t row = 0; row < start.rows(); ++row) {
    if (start.text(row, "deck") == "D_e")
      exam.compare_worded("deck (e): spherical particles", start.number(row, "npar"));
  }
}

//   theta = asin((R2 - R1)/L)                                                (3.16)
//   alpha = acos(((R1 + Rs)^2 + L^2 - (R2 + Rs)^2) / (2 L (R1 + Rs)))        (3.18), beta likewise
//   gamma = 180 deg - alpha - beta,  gamma_1 = 90 deg + theta - alpha        (3.19)
void examine_appendix_e(Examination& exam, const ThesisData& thesis) {
  const std::string name = "appendix_e";
  const double rs = thesis.number(name, "R_s"), r1 = thesis.number(name, "R_1");
  const double r2 = thesis.number(name, "R_2"), l = thesis.number(name, "L");
  const double one = r1 + rs, two = r2 + rs;
  const double theta = std::asin((r2 - r1) / l);
  const double alpha = std::acos((one * one + l * l - two * two) / (2.0 * l * one));
  const double beta = std::acos((two * two + l * l - one * one) / (2.0 * l * two));
  const double gamma = std::numbers::pi - alpha - beta;
  const double gamma_1 = 0.5 * std::numbers::pi + theta - alpha;

  // The spheres themselves, from the fit of the profile
  const sim::ProfileFit fit = button_fit(thesis);
  const double centimetre = unit_in_si("cm");
  exam.compare("R_s",
               thesis.printed(name, "R_s"),
               fit.spheres[0].radius / centimetre,
               "profile fit with 8 chords");
  exam.compare("R_1",
               thesis.printed(name, "R_1"),
               fit.spheres[0].radius / centimetre,
               "profile fit with 8 chords");
  exam.compare("R_2",
               thesis.printed(name, "R_2"),
               fit.spheres[1].radius / centimetre,
               "profile fit with 8 chords");
  exam.compare("L",
               thesis.printed(name, "L"),
               (fit.spheres[1].centre - fit.spheres[0].centre).norm() / centimetre,
               "profile fit with 8 chords");

  exam.compare("alpha", thesis.printed(name, "alpha"), alpha / degree);
  exam.compare("beta", thesis.printed(name, "beta"), beta / degree);
  exam.compare("gamma", thesis.printed(name, "gamma"), gamma / degree);
  exam.compare("gamma_1", thesis.printed(name, "gamma_1"), gamma_1 / degree);
  exam.compare("gamma_2", thesis.printed(name, "gamma_2"), (gamma - gamma_1) / degree);
  exam.compare("sec 4.3.2.1: largest deviation over all pairs",
               thesis.printed("packing_and_flow", "contact_normal_deviation_max"),
               sim::surface_error_of(fit.spheres).contact_normal / degree);
  exam.not_run("sec 4.3.2.1: friction that it equates to",
               thesis.printed("packing_and_flow", "pseudo_friction_equivalent"),
               "no step of Appendix E gives it (errata 35)");
}

}  // namespace graintruth::app
