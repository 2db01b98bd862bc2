#include "sim/contact_batch.h"

namespace graintruth::sim {

template <int D>
void ContactBatch<D>::reserve(int contacts) {
  const std::size_t rows = static_cast<std::size_t>(contacts) + 1;  // one is written ahead
  if (candidate.size() >= rows) return;
  for (auto* column : {&candidate, &group, &was_touching, &pair}) column->resize(rows);
  for (auto* column :
       {&apart, &offset, &arm, &moved.at_centre, &moving.at_centre, &normal, &force}) {
    column->resize(rows);
  }
  for (auto* column : {&moved.spin,
                       &moving.spin,
                       &spring,
                       &tangential_force,
                       &tangential_speed,
                       &moment,
                       &second_moment}) {
    column->resize(rows);
  }
  for (auto* column : {&distance_squared,
                       &reach,
                       &stiffness_factor,
                       &radius,
                       &slip_time,
                       &reduced_mass,
                       &overlap,
                       &stiffness,
                       &sum_of_stiffness,
                       &contact_count,
                       &normal_force,
                       &slides,
                       &normal_speed}) {
    column->resize(rows);
  }
}

template struct ContactBatch<2>;
template struct ContactBatch<3>;

}  // namespace graintruth::sim
