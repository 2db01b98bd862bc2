#include "app/reproduce/targets.h"

#include <array>

namespace graintruth::app {

namespace {

constexpr auto nothing = nullptr;

constexpr std::array targets = {
    Target{"table-1.1", "survey of particle shapes", examine_table_1_1, nothing, true},
    Target{"equations",
           "equations 1.6 to 2.33, restitution and damping",
           examine_equations,
           nothing,
           true},
    Target{"eq-1.28",
           "critical time steps, without the pi that they lack",
           examine_time_step,
           nothing,
           true},
    Target{"eq-2.3", "spheres along the profile of the button", examine_profile_fit, nothing, true},
    Target{"table-3.1",
           "weight at rest, upright, damping ratio 0.5",
           examine_table_3_1,
           simulate_table_3_1,
           true},
    Target{"table-3.2",
           "weight at rest, upright, damping ratio 0.21",
           examine_table_3_2,
           simulate_table_3_2,
           true},
    Target{"table-3.3",
           "weight at rest, lying, damping ratio 0.5",
           examine_table_3_3,
           simulate_table_3_3,
           true},
    Target{"fig-3.5-text",
           "error of the impulse against the time step",
           nothing,
           simulate_collision,
           true},
    Target{"fig-3.7", "sliding down an incline at four frictions", nothing, simulate_sliding, true},
    Target{"fig-3.11",
           "sliding and rebound against the number of contacts",
           nothing,
           simulate_contact_count,
           true},
    Target{"fig-3.12", "a particle on a conveyor", nothing, simulate_conveyor, true},
    Target{"eq-3.7",
           "translation and rotation after an impulse",
           examine_impulse,
           simulate_impulse,
           true},
    Target{"table-3.4",
           "pseudo-friction against sphere density",
           examine_table_3_4,
           simulate_pseudo_friction,
           true},
    Target{"table-3.5",
           "run times of multi-sphere particles",
           examine_table_3_5,
           simulate_run_time_of_clumps,
           true},
    Target{
        "table-3.6", "run times of spheres", examine_table_3_6, simulate_run_time_of_spheres, true},
    Target{
        "table-4.1", "the glued balls: mass, overlap, density", examine_table_4_1, nothing, true},
    Target{"sec-4.2.2", "RMS distances at four frictions", examine_rms, nothing, true},
    Target{
        "table-4.2", "agreement of the micro-scale experiment", examine_table_4_2, nothing, true},
    Target{"table-4.3", "the buttons: size, density, orifices", examine_table_4_3, nothing, true},
    Target{"table-4.4", "Beverloo's C of the experiment", examine_table_4_4, nothing, true},
    Target{"table-4.5", "Beverloo's C of the simulation", examine_table_4_5, nothing, true},
    Target{"fig-4.17", "Beverloo's k from straight lines", examine_beverloo_lines, nothing, true},
    Target{"table-4.6", "t-test of C", examine_table_4_6, nothing, true},
    Target{"table-4.7",
           "t-test of velocities, and their mass balance",
           examine_table_4_7,
           nothing,
           true},
    Target{"fig-4.18", "kinematic constant B", examine_kinematic, nothing, true},
    Target{"study-macro", "200 buttons through five orifices", nothing, simulate_macro, false},
    Target{"eq-5.1", "particles of equal volume", examine_eq_5_1, nothing, true},
    Target{"table-5.1", "parameters of the shape study", examine_table_5_1, nothing, true},
    Target{"table-5.2",
           "shape of the distribution of solid fraction",
           examine_table_5_2,
           nothing,
           true},
    Target{"appendix-d", "what the decks say of themselves", examine_decks, nothing, true},
    Target{"appendix-e",
           "deviation of the button's contact normals",
           examine_appendix_e,
           nothing,
           true},
    Target{"deck-a", "a conical particle between two conveyors", nothing, simulate_deck_a, true},
    Target{"deck-b", "an irregular particle between two conveyors", nothing, simulate_deck_b, true},
    Target{
        "deck-c", "twenty conical particles between two conveyors", nothing, simulate_deck_c, true},
    Target{"deck-d", "singulation of twenty ellipsoids", nothing, simulate_deck_d, true},
    Target{"deck-e", "spheres on a rotating disk", nothing, simulate_deck_e, true},
    Target{"deck-f", "the micro experiment", nothing, simulate_deck_f, true},
};

}  // namespace

std::span<const Target> all_targets() { return targets; }

}  // namespace graintruth::app
