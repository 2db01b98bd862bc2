// Ctrl-C: work stops at the next safe point; what is done stays done.
#pragma once

namespace graintruth::app {

// Catches SIGINT and SIGTERM from now on. A second one ends the program at once.
void catch_interrupts();
bool is_interrupted();

}  // namespace graintruth::app
