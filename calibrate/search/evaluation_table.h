// The table of a search, evaluation by evaluation.
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "calibrate/compare/comparison.h"

namespace graintruth::calibrate {

// Agreement of an evaluation in percent; empty where there is no such thing.
using EvaluationAgreement = std::function<double(const Evaluation&)>;

void write_evaluations(const std::filesystem::path& file,
                       std::span<const Evaluation> evaluations,
                       const EvaluationAgreement& agreement_percent);

}  // namespace graintruth::calibrate
