// Which constants of the two laws of discharge were published, and which are doubtful beside those.
#pragma once

#include <string>
#include <vector>

namespace graintruth::calibrate {

// Sentences, empty where nothing is doubtful. Values somewhat outside what was published are not
// doubted, because grains and bins differ:
//   C  published 0.55 to 0.65, doubtful below 0.3 and above 1
//   k  published 1 to 3, doubtful below 0.6 and above 3.5
// Beverloo, Leniger and van de Velde (1961), Chem. Eng. Sci. 15, 260: C = 0.58, k = 1.4 and 2.9 for
// sand; Nedderman (1992), Statics and Kinematics of Granular Materials, section 10.2; Mankoc et al.
// (2007), Granular Matter 9, 407.
std::vector<std::string> doubts_about_beverloo(double C, double k);

//   B  published 1.3 to 3.5 particle diameters, doubtful below 0.7 and above 6
// Choi, Kudrolli and Bazant (2005), J. Phys. Condens. Matter 17, S2533, with what others measured.
std::vector<std::string> doubts_about_kinematic(double B_over_d);

}  // namespace graintruth::calibrate
