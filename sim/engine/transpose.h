// Between records (what belongs together lies side by side) and columns (one array per number),
// four records at a time: loads, shuffles and stores in place of one number after the other.
// Moves numbers and nothing else, so the bits cannot depend on the processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <utility>

#include "sim/engine/columns.h"

namespace graintruth::sim {

using Quad = double __attribute__((vector_size(4 * sizeof(double))));
using Twin = double __attribute__((vector_size(2 * sizeof(double))));

// Numbers [first, first + 4) of a record, or two.
template <class Record>
[[gnu::always_inline]] inline void read_quad(const Record& record, int first, Quad& quad) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&record);
  std::memcpy(&quad, bytes + first * sizeof(double), sizeof(Quad));
}
template <class Record>
[[gnu::always_inline]] inline void write_quad(const Quad& quad, int first, Record& record) {
  auto* bytes = reinterpret_cast<std::byte*>(&record);
  std::memcpy(bytes + first * sizeof(double), &quad, sizeof(Quad));
}
template <class Record>
[[gnu::always_inline]] inline void read_twin(const Record& record, int first, Twin& twin) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&record);
  std::memcpy(&twin, bytes + first * sizeof(double), sizeof(Twin));
}
template <class Record>
[[gnu::always_inline]] inline void write_twin(const Twin& twin, int first, Record& record) {
  auto* bytes = reinterpret_cast<std::byte*>(&record);
  std::memcpy(bytes + first * sizeof(double), &twin, sizeof(Twin));
}
[[gnu::always_inline]] inline void read_rows(const double* from, Quad& quad) {
  std::memcpy(&quad, from, sizeof(Quad));
}
[[gnu::always_inline]] inline void write_rows(const Quad& quad, double* to) {
  std::memcpy(to, &quad, sizeof(Quad));
}

// Number j of quad i becomes number i of quad j.
[[gnu::always_inline]] inline void transpose(Quad (&quads)[4]) {
  const Quad even_01 = __builtin_shufflevector(quads[0], quads[1], 0, 4, 2, 6);
  const Quad odd_01 = __builtin_shufflevector(quads[0], quads[1], 1, 5, 3, 7);
  const Quad even_23 = __builtin_shufflevector(quads[2], quads[3], 0, 4, 2, 6);
  const Quad odd_23 = __builtin_shufflevector(quads[2], quads[3], 1, 5, 3, 7);
  quads[0] = __builtin_shufflevector(even_01, even_23, 0, 1, 4, 5);
  quads[1] = __builtin_shufflevector(odd_01, odd_23, 0, 1, 4, 5);
  quads[2] = __builtin_shufflevector(even_01, even_23, 2, 3, 6, 7);
  quads[3] = __builtin_shufflevector(odd_01, odd_23, 2, 3, 6, 7);
}

// Quads that cover so many numbers: the last one overlaps the one before rather than reach over the
// end.
constexpr int quad_count(int numbers) { return (numbers + 3) / 4; }
constexpr int quad_begin(int quad, int numbers) {
  return 4 * quad + 4 <= numbers || numbers < 4 ? 4 * quad : numbers - 4;
}

// Quad q of four records to row k and the next three of its columns. All indices are known when
// this is compiled: nothing but loads, shuffles and stores is left.
template <int q, std::size_t Columns, class Record>
[[gnu::always_inline]] inline void quad_to_columns(const Record& a,
                                                   const Record& b,
                                                   const Record& c,
                                                   const Record& d,
                                                   int k,
                                                   const std::array<Rows, Columns>& columns) {
  constexpr int kNumbers = static_cast<int>(Columns);
  constexpr int kFirst = quad_begin(q, kNumbers), kNew = 4 * q - kFirst;
  Quad quads[4];
  read_quad(a, kFirst, quads[0]);
  read_quad(b, kFirst, quads[1]);
  read_quad(c, kFirst, quads[2]);
  read_quad(d, kFirst, quads[3]);
  transpose(quads);
  if constexpr (kNew <= 0) write_rows(quads[0], columns[kFirst] + k);
  if constexpr (kNew <= 1) write_rows(quads[1], columns[kFirst + 1] + k);
  if constexpr (kNew <= 2) write_rows(quads[2], columns[kFirst + 2] + k);
  if constexpr (kFirst + 3 < kNumbers) write_rows(quads[3], columns[kFirst + 3] + k);
}
template <int q, std::size_t Columns, class Record>
[[gnu::always_inline]] inline void quad_to_records(
    const std::array<Rows, Columns>& columns, int k, Record& a, Record& b, Record& c, Record& d) {
  constexpr int kNumbers = static_cast<int>(Columns);
  constexpr int kFirst = quad_begin(q, kNumbers), kNew = 4 * q - kFirst;
  if constexpr (kNew == 2) {
    // Two numbers are left. Writing two of the quad before once more would make a reader wait who
    // comes soon.
    Quad numbers[2];
    read_rows(columns[kFirst + 2] + k, numbers[0]);
    read_rows(columns[kFirst + 3] + k, numbers[1]);
    const Quad of_ac = __builtin_shufflevector(numbers[0], numbers[1], 0, 4, 2, 6);
    const Quad of_bd = __builtin_shufflevector(numbers[0], numbers[1], 1, 5, 3, 7);
    write_twin(__builtin_shufflevector(of_ac, of_ac, 0, 1), kFirst + 2, a);
    write_twin(__builtin_shufflevector(of_bd, of_bd, 0, 1), kFirst + 2, b);
    write_twin(__builtin_shufflevector(of_ac, of_ac, 2, 3), kFirst + 2, c);
    write_twin(__builtin_shufflevector(of_bd, of_bd, 2, 3), kFirst + 2, d);
    return;
  }
  Quad quads[4] = {};
  read_rows(columns[kFirst] + k, quads[0]);
  read_rows(columns[kFirst + 1] + k, quads[1]);
  read_rows(columns[kFirst + 2] + k, quads[2]);
  if constexpr (kFirst + 3 < kNumbers) read_rows(columns[kFirst + 3] + k, quads[3]);
  transpose(quads);
  write_quad(quads[0], kFirst, a);
  write_quad(quads[1], kFirst, b);
  write_quad(quads[2], kFirst, c);
  write_quad(quads[3], kFirst, d);
}

// Numbers of record_of(k), from its first on, each into row k of its column, for k in [0, rows).
// `rows` is a multiple of four. Records have four numbers or more, of which three may be asked for.
template <std::size_t Columns, class RecordOf>
[[gnu::always_inline]] inline void to_columns(int rows,
                                              const RecordOf& record_of,
                                              const std::array<Rows, Columns>& columns) {
  const auto quads = [&]<int... q>(std::integer_sequence<int, q...>)
      __attribute__((always_inline)) {
    for (int k = 0; k < rows; k += 4) {
      const auto &a = record_of(k), &b = record_of(k + 1);
      const auto &c = record_of(k + 2), &d = record_of(k + 3);
      (quad_to_columns<q>(a, b, c, d, k, columns), ...);
    }
  };
  quads(std::make_integer_sequence<int, quad_count(static_cast<int>(Columns))>());
}

// The way back. Of three columns the fourth number is set to zero.
template <std::size_t Columns, class RecordOf>
[[gnu::always_inline]] inline void to_records(int rows,
                                              const std::array<Rows, Columns>& columns,
                                              const RecordOf& record_of) {
  const auto quads = [&]<int... q>(std::integer_sequence<int, q...>)
      __attribute__((always_inline)) {
    for (int k = 0; k < rows; k += 4) {
      auto &a = record_of(k), &b = record_of(k + 1);
      auto &c = record_of(k + 2), &d = record_of(k + 3);
      (quad_to_records<q>(columns, k, a, b, c, d), ...);
    }
  };
  quads(std::make_integer_sequence<int, quad_count(static_cast<int>(Columns))>());
}

}  // namespace graintruth::sim
