#include "sim/engine/snapshot.h"

#include <bit>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

namespace graintruth::sim {
namespace {

constexpr std::string_view kMagic = "GTSNAP04";

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const std::byte byte : bytes) {
    hash = (hash ^ std::to_integer<std::uint64_t>(byte)) * 1099511628211ull;
  }
  return hash;
}

class Writer {
 public:
  void word(const std::uint64_t& value) {
    for (int shift = 0; shift < 64; shift += 8) {
      bytes_.push_back(static_cast<std::byte>((value >> shift) & 0xff));
    }
  }
  std::vector<std::byte>& bytes() { return bytes_; }
  template <class Element>
  void length_of(const std::vector<Element>& vector) {
    word(vector.size());
  }

 private:
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  void word(std::uint64_t& value) {
    if (bytes_.size() - read_ < 8) {
      throw std::invalid_argument("snapshot: ends after " + std::to_string(bytes_.size()) +
                                  " bytes, in the middle of its numbers");
    }
    value = 0;
    for (int shift = 0; shift < 64; shift += 8) {
      value |= std::to_integer<std::uint64_t>(bytes_[read_++]) << shift;
    }
  }
  template <class Element>
  void length_of(std::vector<Element>& vector) {
    std::uint64_t length = 0;
    word(length);
    // Every element takes eight bytes or more
    if (length > (bytes_.size() - read_) / 8) {
      throw std::invalid_argument("snapshot: says that " + std::to_string(length) +
                                  " elements follow, more than its bytes can hold");
    }
    vector.resize(length);
  }
  std::size_t read() const { return read_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t read_ = 0;
};

// The order of the bytes, for writing and for reading alike.
template <class Archive, class Number>
requires std::is_arithmetic_v<std::remove_const_t<Number>>
void walk(Archive& archive, Number& number) {
  using Stored = std::
      conditional_t<std::is_floating_point_v<std::remove_const_t<Number>>, double, std::int64_t>;
  std::uint64_t word = 0;
  if constexpr (std::is_same_v<Archive, Writer>) {
    word = std::bit_cast<std::uint64_t>(static_cast<Stored>(number));
    archive.word(word);
  } else {
    archive.word(word);
    number = static_cast<Number>(std::bit_cast<Stored>(word));
  }
}

template <class Archive, class... Numbers>
requires(sizeof...(Numbers) > 1) void walk(Archive& archive, Numbers&... numbers) {
  (walk(archive, numbers), ...);
}

template <class Archive, class Vector>
void walk_vector(Archive& archive, Vector& vector) {
  for (auto& number : vector) walk(archive, number);
}

template <class Archive, class Motion>
void walk_motion(Archive& archive, Motion& motion) {
  walk_vector(archive, motion.velocity);
  walk(archive, motion.start_time, motion.end_time);
  walk_vector(archive, motion.angular_velocity);
  walk_vector(archive, motion.pivot);
}

template <class Archive, class SomeWall>
void walk_wall(Archive& archive, SomeWall& wall) {
  auto shape = static_cast<std::int64_t>(wall.shape);
  walk(archive, shape);
  if constexpr (!std::is_const_v<SomeWall>) wall.shape = static_cast<Wall::Shape>(shape);
  walk_vector(archive, wall.from);
  walk_vector(archive, wall.to);
  walk_vector(archive, wall.point);
  walk_vector(archive, wall.normal);
  walk(archive, wall.radius, wall.length);
  archive.length_of(wall.corners);
  for (auto& corner : wall.corners) walk_vector(archive, corner);
  walk_motion(archive, wall.motion);
  walk_motion(archive, wall.drag);
  walk(archive, wall.opens_at, wall.material, wall.body);
}

template <class Archive, class Contacts>
void walk_contacts(Archive& archive, Contacts& contacts) {
  archive.length_of(contacts);
  for (auto& c : contacts) {
    walk(archive, c.first_sphere, c.second, c.state);
    walk(archive, c.spring[0], c.spring[1], c.spring[2]);
    walk(archive, c.elastic_force, c.stiffness);
    walk(archive, c.rolled[0], c.rolled[1], c.rolled[2]);
  }
}

template <class Archive, class SomeSnapshot>
void walk_snapshot(Archive& archive, SomeSnapshot& s) {
  walk(archive, s.dimensions, s.body_count, s.sphere_count);
  walk(archive, s.time, s.time_step, s.longest_time_step, s.slip_time, s.global_damping);
  walk(archive, s.damping_loss, s.tangential_work, s.wall_work, s.crossing_work);
  archive.length_of(s.bodies);
  for (auto& number : s.bodies) walk(archive, number);
  walk_contacts(archive, s.between_bodies);
  walk_contacts(archive, s.with_walls);
  archive.length_of(s.pairs);
  for (auto& pair : s.pairs) {
    walk(archive, pair.normal_modulus, pair.tangential_ratio, pair.friction);
    walk(archive,
         pair.static_friction,
         pair.rolling_friction,
         pair.damping_ratio,
         pair.normal_damping,
         pair.tangential_damping);
  }
  archive.length_of(s.walls);
  for (auto& wall : s.walls) walk_wall(archive, wall);
  archive.length_of(s.wall_surfaces);
  for (auto& number : s.wall_surfaces) walk(archive, number);
}

}  // namespace

Snapshot without_bodies(const Snapshot& snapshot,
                        std::span<const char> gone,
                        std::span<const std::int64_t> first_sphere) {
  Snapshot left = snapshot;
  left.bodies.clear();
  left.body_count = 0;
  left.sphere_count = 0;
  // The new index of each sphere; -1 where its body is gone
  std::vector<std::int64_t> sphere(static_cast<std::size_t>(first_sphere.back()), -1);
  const auto numbers = static_cast<std::ptrdiff_t>(numbers_per_body(snapshot.dimensions));
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (gone[i] != 0) continue;
    const auto of_body = snapshot.bodies.begin() + static_cast<std::ptrdiff_t>(i) * numbers;
    left.bodies.insert(left.bodies.end(), of_body, of_body + numbers);
    ++left.body_count;
    for (std::int64_t s = first_sphere[i]; s < first_sphere[i + 1]; ++s) {
      sphere[static_cast<std::size_t>(s)] = left.sphere_count++;
    }
  }
  const auto keep = [&sphere](std::vector<KeptContact>& contacts, bool between_bodies) {
    std::vector<KeptContact> kept;
    for (KeptContact contact : contacts) {
      contact.first_sphere = sphere[static_cast<std::size_t>(contact.first_sphere)];
      if (between_bodies) contact.second = sphere[static_cast<std::size_t>(contact.second)];
      if (contact.first_sphere >= 0 && contact.second >= 0) kept.push_back(contact);
    }
    contacts = std::move(kept);
  };
  keep(left.between_bodies, true);
  keep(left.with_walls, false);
  return left;
}

std::vector<std::byte> to_bytes(const Snapshot& snapshot) {
  Writer writer;
  for (const char letter : kMagic) writer.bytes().push_back(static_cast<std::byte>(letter));
  walk_snapshot(writer, snapshot);
  writer.word(hash_of(writer.bytes()));
  return std::move(writer.bytes());
}

Snapshot snapshot_from_bytes(std::span<const std::byte> bytes) {
  const auto is_magic = [&] {
    for (std::size_t i = 0; i < kMagic.size(); ++i) {
      if (bytes[i] != static_cast<std::byte>(kMagic[i])) return false;
    }
    return true;
  };
  if (bytes.size() < kMagic.size() + 8 || !is_magic()) {
    throw std::invalid_argument("snapshot: does not begin with GTSNAP02, so it is none");
  }
  const std::span<const std::byte> content = bytes.first(bytes.size() - 8);
  Reader end(bytes.last(8));
  std::uint64_t hash = 0;
  end.word(hash);
  if (hash != hash_of(content)) {
    throw std::invalid_argument(
        "snapshot: its hash does not fit its content, it was cut off or changed");
  }
  Snapshot snapshot;
  const std::span<const std::byte> numbers = content.subspan(kMagic.size());
  Reader reader(numbers);
  walk_snapshot(reader, snapshot);
  if (reader.read() != numbers.size()) {
    throw std::invalid_argument("snapshot: has more bytes than its numbers take");
  }
  return snapshot;
}

}  // namespace graintruth::sim
