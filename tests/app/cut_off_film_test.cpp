// A film whose header announces more than the file holds shows its fault only when it is read.
#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

using CutOffFilm = BadInput;

// The second film is being tracked when the first breaks off; nothing is left of it either.
TEST_F(CutOffFilm, IsRefusedAndEndsTheWorkOnTheOthers) {
  std::string text = film_experiment();
  for (int n = 3; n <= 5; ++n) {
    const std::string film = (bundled_micro() / ("rep" + std::to_string(n) + ".mp4")).string();
    text = with(text, "[[replicate]]\nvideo = \"" + film + "\"\n", "");
  }
  const std::string film = content_of(bundled_micro() / "rep1.mp4");
  const auto half = folder_.write("half.mp4", film.substr(0, film.size() / 2));
  expect_refusal(calibrate(with(text, (bundled_micro() / "rep1.mp4").string(), half.string())),
                 {"half.mp4", "breaks off"});
}

}  // namespace
}  // namespace graintruth::tests
