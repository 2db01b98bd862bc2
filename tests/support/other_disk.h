// Commands that see a file system of their own: full, or read-only. Nobody else sees it, and it is
// gone with them.
#pragma once

#include <unistd.h>

#include <string>
#include <vector>

#include "tests/support/run_program.h"

namespace graintruth::tests {

// A shell script that may mount what it likes. Nothing runs where that is not permitted: see
// can_mount().
inline ProgramOutcome run_with_own_mounts(const std::string& script) {
  const std::string how = geteuid() == 0 ? "-m" : "-rm";
  return run_program({how, "sh", "-c", script}, "/usr/bin/unshare");
}

inline bool can_mount() {
  return access("/usr/bin/unshare", X_OK) == 0 &&
         run_with_own_mounts("mount -t tmpfs none /mnt").status == 0;
}

}  // namespace graintruth::tests
