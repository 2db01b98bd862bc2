#include "datasets/scene/particle_files.h"

#include <fmt/format.h>

#include <iterator>

namespace graintruth::datasets {

namespace {

using Eigen::Vector3d;
using Text = std::back_insert_iterator<std::string>;

// Six digits are a micrometre in a metre: pictures need no more.
std::string vectors_text(const std::vector<Vector3d>& vectors) {
  std::string text;
  for (const Vector3d& v : vectors) {
    fmt::format_to(Text(text), "{:.7g} {:.7g} {:.7g}\n", v.x(), v.y(), v.z());
  }
  return text;
}

template <class Number>
std::string numbers_text(const std::vector<Number>& numbers) {
  std::string text;
  for (const Number number : numbers) fmt::format_to(Text(text), "{:.7g}\n", double(number));
  return text;
}

std::string data_array(const char* type,
                       const char* name,
                       int components,
                       const std::string& text) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n{}"
      "</DataArray>\n",
      type,
      name,
      components,
      text);
}

std::string poly_data(const std::string& counts, const std::string& pieces) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<PolyData>\n<Piece {}>\n{}</Piece>\n</PolyData>\n</VTKFile>\n",
      counts,
      pieces);
}

std::vector<int> counting(std::size_t count) {
  std::vector<int> numbers(count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<int>(i);
  return numbers;
}

}  // namespace

std::string vtp_of_spheres(const SphereCloud& cloud) {
  const std::size_t count = cloud.centre.size();
  std::vector<int> ends = counting(count);
  for (int& end : ends) ++end;
  std::string pieces;
  pieces += "<PointData Scalars=\"radius\" Vectors=\"velocity\">\n";
  pieces += data_array("Float64", "radius", 1, numbers_text(cloud.radius));
  pieces += data_array("Float64", "velocity", 3, vectors_text(cloud.velocity));
  pieces += data_array("Int32", "particle", 1, numbers_text(cloud.particle));
  pieces += data_array("Int32", "type", 1, numbers_text(cloud.type));
  pieces += "</PointData>\n<Points>\n";
  pieces += data_array("Float64", "points", 3, vectors_text(cloud.centre));
  pieces += "</Points>\n<Verts>\n";
  pieces += data_array("Int32", "connectivity", 1, numbers_text(counting(count)));
  pieces += data_array("Int32", "offsets", 1, numbers_text(ends));
  pieces += "</Verts>\n";
  return poly_data(fmt::format("NumberOfPoints=\"{0}\" NumberOfVerts=\"{0}\" NumberOfLines=\"0\" "
                               "NumberOfStrips=\"0\" NumberOfPolys=\"0\"",
                               count),
                   pieces);
}

std::string vtp_of_patches(const std::vector<Patch>& patches, const std::vector<int>& wall) {
  std::vector<Vector3d> points;
  std::vector<int> ends;
  for (const Patch& patch : patches) {
    points.insert(points.end(), patch.begin(), patch.end());
    ends.push_back(static_cast<int>(points.size()));
  }
  std::string pieces;
  pieces += "<CellData Scalars=\"wall\">\n" + data_array("Int32", "wall", 1, numbers_text(wall));
  pieces += "</CellData>\n<Points>\n" + data_array("Float64", "points", 3, vectors_text(points));
  pieces += "</Points>\n<Polys>\n";
  pieces += data_array("Int32", "connectivity", 1, numbers_text(counting(points.size())));
  pieces += data_array("Int32", "offsets", 1, numbers_text(ends));
  pieces += "</Polys>\n";
  return poly_data(fmt::format("NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
                               "NumberOfStrips=\"0\" NumberOfPolys=\"{}\"",
                               points.size(),
                               patches.size()),
                   pieces);
}

std::string pvd_of(const std::vector<std::pair<double, std::string>>& files) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const auto& [time, name] : files) {
    fmt::format_to(
        Text(text), "<DataSet timestep=\"{:.9g}\" part=\"0\" file=\"{}\"/>\n", time, name);
  }
  return text + "</Collection>\n</VTKFile>\n";
}

std::string lammps_snapshot(const SphereCloud& cloud, long step) {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();
  for (std::size_t i = 0; i < cloud.centre.size(); ++i) {
    const Vector3d reach = Vector3d::Constant(cloud.radius[i]);
    low = i == 0 ? Vector3d(cloud.centre[i] - reach) : low.cwiseMin(cloud.centre[i] - reach);
    high = i == 0 ? Vector3d(cloud.centre[i] + reach) : high.cwiseMax(cloud.centre[i] + reach);
  }
  std::string text = fmt::format(
      "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS ff ff ff\n{:.7g} {:.7g}\n"
      "{:.7g} {:.7g}\n{:.7g} {:.7g}\nITEM: ATOMS id mol type x y z radius vx vy vz\n",
      step,
      cloud.centre.size(),
      low.x(),
      high.x(),
      low.y(),
      high.y(),
      low.z(),
      high.z());
  for (std::size_t i = 0; i < cloud.centre.size(); ++i) {
    const Vector3d& c = cloud.centre[i];
    const Vector3d& v = cloud.velocity[i];
    fmt::format_to(Text(text),
                   "{} {} {} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g} {:.7g}\n",
                   i + 1,
                   cloud.particle[i],
                   cloud.type[i],
                   c.x(),
                   c.y(),
                   c.z(),
                   cloud.radius[i],
                   v.x(),
                   v.y(),
                   v.z());
  }
  return text;
}

}  // namespace graintruth::datasets
