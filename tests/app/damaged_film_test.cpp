// A film that is damaged in between shows its fault only when it is read.
#include "tests/app/bad_input.h"

namespace graintruth::tests {
namespace {

using DamagedFilm = BadInput;

// The second film is being tracked when the first turns out to be damaged; nothing is left of it
// either.
TEST_F(DamagedFilm, IsRefusedAndEndsTheWorkOnTheOthers) {
  std::string text = film_experiment();
  for (int n = 3; n <= 5; ++n) {
    const std::string film = (bundled_micro() / ("rep" + std::to_string(n) + ".mp4")).string();
    text = with(text, "[[replicate]]\nvideo = \"" + film + "\"\n", "");
  }
  std::string film = content_of(bundled_micro() / "rep1.mp4");
  for (std::size_t at = film.size() / 3; at < film.size() / 2; at += 500) film[at] ^= '\x55';
  const auto damaged = folder_.write("damaged.mp4", film);
  expect_refusal(calibrate(with(text, (bundled_micro() / "rep1.mp4").string(), damaged.string())),
                 {"damaged.mp4", "damaged in between"});
}

}  // namespace
}  // namespace graintruth::tests
