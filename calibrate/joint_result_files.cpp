#include "calibrate/joint_result_files.h"

#include "calibrate/result_json.h"

namespace graintruth::calibrate {

namespace {

// One line of the experiments: what it adds to the sum, and by what it is judged.
Json member_json(const JointMember& member, const JointMemberResult& result) {
  const datasets::Experiment& experiment =
      member.tracks ? member.tracks->experiment : member.bin->experiment;
  Json json = {{"name", member.name},
               {"title", experiment.title},
               {"compared", member.tracks ? "tracks" : "flow"},
               {"replicates", experiment.replicates.size()},
               {"weight", member.weight},
               {"objective", result.objective}};
  if (result.tracks) {
    json["agreement_percent_student_t"] = result.tracks->score.student.percent;
    json["ceiling_percent_student_t"] = result.tracks->context.student_ceiling;
    json["agreement_percent"] = result.tracks->score.thesis.percent;
  } else {
    const BinScore& score = result.bin->score;
    json["mean_signed_error"] = score.mean_signed_error;
    int held_out = 0;
    for (const OrificeComparison& row : score.orifices) held_out += row.held_out ? 1 : 0;
    json["orifices"] = score.orifices.size();
    json["held_out_orifices"] = held_out;
  }
  return json;
}

}  // namespace

void write_joint_calibration(const datasets::RunFolder& folder,
                             const datasets::Experiment& common,
                             std::span<const JointMember> members,
                             const CalibrationOptions& options,
                             const JointCalibrationResult& result,
                             double wall_time) {
  write_evaluations(folder.table("evaluations"), result.evaluations, {});
  write_profiles(folder, result);
  Json json = head_json(common, "joint_calibration");
  add_search(result, options, json);
  json["objective"]["best"] = result.objective;
  for (std::size_t i = 0; i < members.size(); ++i)
    json["experiments"].push_back(member_json(members[i], result.members[i]));
  json["wall_time_s"] = wall_time;
  write_json(folder.result(), json);
}

}  // namespace graintruth::calibrate
