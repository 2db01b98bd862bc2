// Plates in a box that run out through an opening in its floor, and how many had left. Of a film
// whose moving plates are smeared: what stands still.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/imports/stagnant.h"
#include "tracking/particle_tracker.h"
#include "tracking/plates/bed_tracks.h"
#include "tracking/plates/stagnant.h"

namespace graintruth::tracking {

struct BedSummary {
  int stated = 0;           // plates, by the experiment file
  int found_first = 0;      // in the first frame
  int discharged = 0;       // crossed the level of the floor by the end of the film
  int remaining = 0;        // seen above it at the end
  int unaccounted = 0;      // neither: lost inside the box
  int filled = 0;           // sightings found afterwards between frames in which a plate was seen
  int losses = 0;           // times that a plate was not where it was predicted
  double size_ratio = 1.0;  // true size over the stated one, as contacts and outlines tell
  double semi_major_learned_mm = 0.0, semi_minor_learned_mm = 0.0;
  double gravity_measured = 0.0;     // m/s2, of plates below the opening; NaN where too few fell
  std::string scan;                  // "progressive", "even rows first", "odd rows first"
  double sharpness = 1.0;            // of moving places over the bed at rest, see stagnant.h
  std::vector<int> doubtful_frames;  // with plates that were not found
};

// Of a film whose moving plates are smeared, what stands still (datasets/imports/stagnant.h) from
// each frame to the one that is `frames_apart` later, and up to which height.
struct StagnantBed {
  int frames_apart = 0;
  std::vector<datasets::StagnantMap> maps;  // one a frame
  std::vector<double> x;                    // m
  std::vector<std::vector<double>> height;  // m, of each frame and x; NaN over the orifice
};

class BedTracker : public ParticleTracker {
 public:
  // Throws InputError where plates cannot be followed in this view.
  BedTracker(const datasets::TrackingSpec& spec, const datasets::Film& film);

  bool looks_ahead() const override { return true; }
  void look_ahead(const Picture& picture, const FilmCamera& camera) override;
  void find_first(const Picture& picture,
                  const FilmCamera& camera,
                  TrackingSummary& summary) override;
  void follow(const Picture& picture) override;
  datasets::Trajectories finish(TrackingSummary& summary) override;
  void draw(cv::Mat& picture, const Camera& camera, const DrawnBody& body) const override;
  bool is_crowd() const override { return true; }
  void describe(nlohmann::ordered_json& film) const override;
  std::map<std::string, datasets::Table> tables() const override;

  // After `finish`.
  const BedSummary& bed() const { return bed_; }
  const StagnantBed& stagnant() const { return stagnant_; }  // empty where plates were tracked

 private:
  bool is_smeared() const { return bed_.sharpness < least_sharpness; }
  void judge_size(TrackingSummary& summary);
  double find_event(int frames, TrackingSummary& summary) const;
  datasets::Trajectories trajectories_of(double zero, TrackingSummary& summary);
  // The plates of the first frame, each as long as its place stands still.
  datasets::Trajectories resting_plates(TrackingSummary& summary);
  void count_plates(int frames);
  void measure_gravity(TrackingSummary& summary);
  void judge(TrackingSummary& summary) const;

  datasets::TrackingSpec spec_;
  datasets::Film film_;
  PlateShape nominal_;
  // From the look ahead
  SharpnessWatcher sharpness_;
  Picture first_picture_, last_picture_;
  int pictures_ = 0;
  // From the first picture on
  std::optional<BedScene> scene_;
  std::optional<FirstBed> first_;
  std::optional<BedTracks> tracks_;
  std::optional<StagnantWatcher> still_;
  std::optional<OrificeWatcher> orifice_;
  int opened_at_ = -1;
  BedSummary bed_;
  StagnantBed stagnant_;
  std::vector<double> time_;  // s, of the tracks
};

// Nothing where the body is no plate, or lies in no box.
std::unique_ptr<ParticleTracker> make_bed_tracker(const datasets::TrackingSpec& spec,
                                                  const datasets::Film& film);

}  // namespace graintruth::tracking
