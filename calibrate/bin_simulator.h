// The adapter to the embedded simulator for particles that run out of a bin.
#pragma once

#include "calibrate/bin_problem.h"
#include "calibrate/dem_simulator.h"

namespace graintruth::calibrate {

// The run of one film, simulated: its bed with a draw of the tracking error, moved apart where the
// model's outline overlaps (or, where the film tells none, a bed prepared as in thesis 4.3.4: rows
// of particles at random angles that fall and settle without friction), settled on the closed
// orifice with the friction of the request, then opened at time 0 and measured as the film is.
// Particles are taken out once they have fallen a diameter below the floor. The panes exert no
// force.
Simulator make_bin_simulator(const BinStart& start, const DemSimulatorOptions& options);

// The modulus that is simulated, Pa: that of the bench, or the lower one at which the hardest
// expected impact (a fall by the width of the orifice) makes an overlap of 1 % of the particle
// diameter. A softer contact lasts longer and allows a longer time step; above that stiffness flow
// hardly depends on it.
double simulated_modulus(const BinStart& start);

// The largest fraction of the Rayleigh step that gives every contact at least 20 steps.
double largest_time_step_fraction(const BinStart& start);
// At which this holds for every film.
double largest_time_step_fraction(const BinProblem& problem);

}  // namespace graintruth::calibrate
