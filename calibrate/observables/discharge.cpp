#include "calibrate/observables/discharge.h"

namespace graintruth::calibrate {

namespace {

const std::vector<double>* detail(const Channel* channel, const char* name) {
  if (channel == nullptr) return nullptr;
  const auto at = channel->details.find(name);
  return at == channel->details.end() ? nullptr : &at->second;
}

}  // namespace

std::optional<Discharge> discharge_of(const datasets::Recording& recording,
                                      const Situation& situation) {
  const BulkRig rig = bulk_rig(situation);
  // A curve that was recorded beside tracks is the measurement; without an opening grains may leave
  // where no track shows it
  if (recording.discharge && (!recording.tracks || !situation.rig.opening))
    return measure_discharge(*recording.discharge, situation.particle.count, rig);
  if (recording.tracks && recording.tracks->frames() > 0)
    return measure_discharge(*recording.tracks, rig);
  return std::nullopt;
}

void put_discharge(const Discharge& discharge, bool of_tracks, Channel& channel) {
  channel.details["discharge"] = {static_cast<double>(discharge.particles),
                                  static_cast<double>(discharge.over_orifice),
                                  discharge.from,
                                  discharge.to,
                                  static_cast<double>(discharge.together),
                                  of_tracks ? 1.0 : 0.0};
  channel.details["times_s"] = discharge.times;
}

void put_bed(const BedShape& bed, Channel& channel) {
  channel.details["bed"] = {bed.area, bed.solid_fraction, bed.areal_density};
  channel.details["surface_m"] = bed.surface;
}

void put_profile(const VelocityProfile& profile, Channel& channel) {
  channel.details["height_m"] = {profile.height};
  channel.details["profile"] = {profile.areal_density, profile.flux};
  std::vector<double>& samples = channel.details["samples"];
  for (const VelocitySample& sample : profile.samples) {
    for (const double value : {sample.x, sample.velocity, sample.standard_uncertainty})
      samples.push_back(value);
  }
}

BulkMeasurement bulk_from(const std::function<const Channel*(std::string_view)>& of) {
  BulkMeasurement bulk;
  const Channel *rate = of("discharge_rate"), *density = of("flowing_density"),
                *profile = of("velocity_profile");
  if (const auto* numbers = detail(rate, "discharge")) {
    bulk.discharge = {.particles = static_cast<int>((*numbers)[0]),
                      .over_orifice = static_cast<int>((*numbers)[1]),
                      .from = (*numbers)[2],
                      .to = (*numbers)[3],
                      .times = *detail(rate, "times_s"),
                      .together = static_cast<int>((*numbers)[4])};
    bulk.of_tracks = (*numbers)[5] > 0.0;
  }
  if (const auto* numbers = detail(density, "bed")) {
    bulk.at_rest = {.surface = *detail(density, "surface_m"),
                    .area = (*numbers)[0],
                    .solid_fraction = (*numbers)[1],
                    .areal_density = (*numbers)[2]};
  }
  if (density && density->is_known() && density->values.front() > 0.0)
    bulk.flowing_density = density->values.front();
  if (const auto* numbers = detail(profile, "profile")) {
    bulk.profile.height = detail(profile, "height_m")->front();
    bulk.profile.areal_density = (*numbers)[0];
    bulk.profile.flux = (*numbers)[1];
    const std::vector<double>& samples = *detail(profile, "samples");
    for (std::size_t i = 0; i + 2 < samples.size(); i += 3)
      bulk.profile.samples.push_back({samples[i], samples[i + 1], samples[i + 2]});
  }
  if (const auto* heights = detail(profile, "stagnant_heights_m")) bulk.stagnant_heights = *heights;
  return bulk;
}

}  // namespace graintruth::calibrate
