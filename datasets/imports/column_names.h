// The one table of what columns are called, in files of ours, of users and of other programs: for
// tracks trackpy, TrackMate, ImageJ (Results, Manual Tracking, MTrackJ) and RodTracker; for
// discharge a load cell; for the fits the words of theses and papers. See quantity_column.h for how
// names and units are matched.
#pragma once

#include "datasets/imports/quantity_column.h"

namespace graintruth::datasets::columns {

// Positions may be in pixels, which only the scale of the picture turns into metres: `in_si` of
// such a unit is 0. A position without a unit is in pixels.
inline constexpr std::array position_units{Unit{"m", 1.0},
                                           Unit{"cm", 1e-2},
                                           Unit{"mm", 1e-3},
                                           Unit{"um", 1e-6},
                                           Unit{"micron", 1e-6},
                                           Unit{"microns", 1e-6},
                                           Unit{"px", 0.0},
                                           Unit{"pixel", 0.0},
                                           Unit{"pixels", 0.0},
                                           Unit{"", 0.0}};
inline bool is_in_pixels(const Unit& unit) { return unit.in_si == 0.0; }

inline constexpr std::array clock_units{Unit{"s", 1.0},
                                        Unit{"ms", 1e-3},
                                        Unit{"sec", 1.0},
                                        Unit{"seconds", 1.0},
                                        Unit{"msec", 1e-3},
                                        Unit{"min", 60.0}};
// ImageJ writes degrees without saying so.
inline constexpr std::array direction_units{
    Unit{"rad", 1.0}, Unit{"deg", radians_per_degree}, Unit{"", radians_per_degree}};
inline constexpr std::array ellipse_direction_units{
    Unit{"rad", 1.0}, Unit{"radians", 1.0}, Unit{"", 1.0}};
// Of a balance; a cell may tell a weight in newtons, which only gravity turns into a mass.
inline constexpr Unit newton{"n", 1.0};
inline constexpr std::array balance_units{
    Unit{"kg", 1.0}, Unit{"g", 1e-3}, Unit{"mg", 1e-6}, newton};
inline bool is_a_weight(const Unit& unit) { return unit.suffix == newton.suffix; }

inline constexpr std::array share_units{Unit{"percent", 1e-2}, Unit{"pct", 1e-2}};

namespace names {
using Names = std::string_view;
inline constexpr std::array<Names, 10> particle{"particle",
                                                "track_id",
                                                "track",
                                                "track_n",
                                                "track_no",
                                                "track_number",
                                                "tid",
                                                "trajectory",
                                                "particle_id",
                                                "object_id"};
inline constexpr std::array<Names, 3> frame{"frame", "frame_number", "frame_no"};
inline constexpr std::array<Names, 4> slice{"slice", "slice_n", "slice_no", "slice_number"};
inline constexpr std::array<Names, 4> time{"time", "t", "position_t", "elapsed_time"};
inline constexpr std::array<Names, 6> right{
    "x", "position_x", "x_position", "pos_x", "centroid_x", "centre_x"};
inline constexpr std::array<Names, 6> vertical{
    "y", "position_y", "y_position", "pos_y", "centroid_y", "centre_y"};
inline constexpr std::array<Names, 2> height{"z", "position_z"};
inline constexpr std::array<Names, 3> direction{"angle", "orientation", "theta"};
inline constexpr std::array<Names, 1> ellipse_direction{"ellipse_theta"};
inline constexpr std::array<Names, 1> right_error{"sigma_x"};
inline constexpr std::array<Names, 1> height_error{"sigma_z"};
inline constexpr std::array<Names, 2> either_error{"ep", "position_error"};
inline constexpr std::array<Names, 1> direction_error{"sigma_angle"};

inline constexpr std::array<Names, 8> discharged_mass{
    "discharged_mass", "mass", "cumulative_mass", "mass_out", "weight", "load", "reading", "m"};
inline constexpr std::array<Names, 4> remaining_mass{
    "remaining_mass", "mass_remaining", "mass_left", "bin_mass"};
inline constexpr std::array<Names, 2> discharged_share{"discharged", "discharged_mass"};

inline constexpr std::array<Names, 10> orifice{"orifice",
                                               "orifice_d",
                                               "orifice_width",
                                               "orifice_diameter",
                                               "opening",
                                               "d0",
                                               "d_0",
                                               "d_o",
                                               "outlet",
                                               "slot_width"};
// Beverloo's D is the orifice. Beside a D0 it is the silo.
inline constexpr std::array<Names, 1> capital_diameter{"D"};
inline constexpr std::array<Names, 5> silo{
    "silo_diameter", "silo_width", "silo", "bin_width", "bin_diameter"};
inline constexpr std::array<Names, 7> rate{
    "flow_rate", "flow_rate_q", "q", "w", "rate", "discharge_rate", "mass_flow_rate"};
inline constexpr std::array<Names, 27> rate_error{"flow_rate_standard_uncertainty",
                                                  "flow_rate_uncertainty",
                                                  "flow_rate_se",
                                                  "flow_rate_sd",
                                                  "flow_rate_std",
                                                  "flow_rate_error",
                                                  "rate_uncertainty",
                                                  "rate_se",
                                                  "rate_sd",
                                                  "rate_std",
                                                  "rate_error",
                                                  "q_uncertainty",
                                                  "q_se",
                                                  "q_sd",
                                                  "q_std",
                                                  "q_err",
                                                  "q_error",
                                                  "sigma_q",
                                                  "u_q",
                                                  "w_uncertainty",
                                                  "w_se",
                                                  "w_sd",
                                                  "w_std",
                                                  "w_err",
                                                  "w_error",
                                                  "sigma_w",
                                                  "u_w"};
inline constexpr std::array<Names, 4> areal_density{
    "areal_density", "areal_density_rho", "rho_areal", "rho"};
inline constexpr std::array<Names, 4> bulk_density{"bulk_density", "density", "rho_bulk", "rho"};
inline constexpr std::array<Names, 6> particle_diameter{
    "particle_diameter", "grain_diameter", "particle_size", "grain_size", "d_p", "dp"};
inline constexpr std::array<Names, 1> small_diameter{"d"};
inline constexpr std::array<Names, 5> particle_density{
    "particle_density", "grain_density", "solid_density", "rho_p", "rho_s"};
inline constexpr std::array<Names, 4> place{"x", "position", "place", "distance"};
inline constexpr std::array<Names, 6> velocity{
    "velocity", "v", "speed", "vertical_velocity", "velocity_z", "vz"};
inline constexpr std::array<Names, 14> velocity_error{"velocity_standard_uncertainty",
                                                      "velocity_uncertainty",
                                                      "velocity_se",
                                                      "velocity_sd",
                                                      "velocity_std",
                                                      "velocity_error",
                                                      "v_uncertainty",
                                                      "v_se",
                                                      "v_sd",
                                                      "v_std",
                                                      "v_err",
                                                      "v_error",
                                                      "sigma_v",
                                                      "u_v"};
}  // namespace names

// Tracks
inline constexpr Quantity particle{"which particle it is", names::particle, plain};
inline constexpr Quantity frame{"the frame, counted from 0", names::frame, plain};
inline constexpr Quantity slice{"the slice, counted from 1", names::slice, plain};
inline constexpr Quantity time{"the time", names::time, clock_units};
inline constexpr Quantity right{"the position to the right", names::right, position_units};
inline constexpr Quantity vertical{
    "the position along the picture's height", names::vertical, position_units};
inline constexpr Quantity height{"the height", names::height, position_units};
// Counter-clockwise from +x as one sees the picture
inline constexpr Quantity direction{"the long axis's direction", names::direction, direction_units};
// From the file's own x axis to its own y axis
inline constexpr Quantity ellipse_direction{
    "the ellipse's direction", names::ellipse_direction, ellipse_direction_units};
inline constexpr Quantity right_error{"the error of x", names::right_error, position_units};
inline constexpr Quantity height_error{"the error of z", names::height_error, position_units};
inline constexpr Quantity either_error{
    "the error of a position", names::either_error, position_units};
inline constexpr Quantity direction_error{
    "the error of the angle", names::direction_error, direction_units};

// Discharge curves
inline constexpr Quantity discharged_mass{
    "the mass that has left", names::discharged_mass, balance_units};
inline constexpr Quantity remaining_mass{
    "the mass still in the bin", names::remaining_mass, balance_units};
inline constexpr Quantity discharged_share{
    "the share of the mass that has left", names::discharged_share, share_units};

// Tables of the fits
inline constexpr Quantity orifice{"the orifice's width", names::orifice, length_units};
inline constexpr Quantity rate{"the flow rate", names::rate, mass_rate_units};
inline constexpr Quantity rate_error{
    "the flow rate's standard uncertainty", names::rate_error, mass_rate_units};
inline constexpr Quantity areal_density{
    "the bed's areal density", names::areal_density, areal_density_units};
inline constexpr Quantity bulk_density{
    "the bed's bulk density", names::bulk_density, density_units};
inline constexpr Quantity particle_diameter{
    "the particles' diameter", names::particle_diameter, length_units, names::small_diameter};
// Called D, and nothing else
inline constexpr Quantity capital_diameter{
    "the orifice's width", {}, length_units, names::capital_diameter};
inline constexpr Quantity silo{"the silo's width", names::silo, length_units};
inline constexpr Quantity particle_density{
    "the particles' density", names::particle_density, density_units};
inline constexpr Quantity place{"the place across the bed", names::place, length_units};
inline constexpr Quantity velocity{"the vertical velocity", names::velocity, speed_units};
inline constexpr Quantity velocity_error{
    "the velocity's standard uncertainty", names::velocity_error, speed_units};

}  // namespace graintruth::datasets::columns
