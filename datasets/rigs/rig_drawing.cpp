#include "datasets/rigs/rig_drawing.h"

#include <toml++/toml.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <sstream>

#include "datasets/store/input_error.h"

namespace graintruth::datasets {

namespace {

using Path = std::vector<TomlStep>;

// Functions of an angle by which coordinates may depend on it.
struct Form {
  std::string_view name;
  double (*of)(double angle);
};
constexpr std::array forms = {Form{"plain", [](double a) { return a; }},
                              Form{"cot", [](double a) { return 1.0 / std::tan(a); }},
                              Form{"tan", [](double a) { return std::tan(a); }},
                              Form{"sin", [](double a) { return std::sin(a); }},
                              Form{"cos", [](double a) { return std::cos(a); }}};

// What is drawn of a rig, before it is known how it depends on dimensions.
struct Shape {
  std::vector<Eigen::Vector2d> corners;
  std::vector<RigDrawing::Line> lines;
  std::vector<RigDrawing::Circle> circles;

  void add_line(const std::string& name, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    lines.push_back({name, corners.size(), corners.size() + 1});
    corners.insert(corners.end(), {from, to});
  }
};

Eigen::Vector2d seen(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }

// From the front: what lies along the line of sight is a line or a circle.
void add_seen(const SceneWall& wall, Shape& shape) {
  using Kind = SceneWall::Kind;
  if (wall.kind == Kind::segment) {
    shape.add_line(wall.name, seen(wall.points[0]), seen(wall.points[1]));
  } else if (wall.kind == Kind::polygon) {
    for (std::size_t i = 0; i < wall.points.size(); ++i) {
      const Eigen::Vector2d from = seen(wall.points[i]),
                            to = seen(wall.points[(i + 1) % wall.points.size()]);
      if (from != to) shape.add_line(wall.name, from, to);
    }
  } else if (wall.kind == Kind::cylinder) {
    const Eigen::Vector3d axis = (wall.points[1] - wall.points[0]).normalized();
    const Eigen::Vector2d from = seen(wall.points[0]), to = seen(wall.points[1]);
    if (std::abs(axis.y()) > 0.5) {
      shape.circles.push_back({wall.name, shape.corners.size(), shape.corners.size() + 1});
      shape.corners.insert(shape.corners.end(), {from, from + Eigen::Vector2d(wall.radius, 0.0)});
    } else {
      const Eigen::Vector2d across = wall.radius * Eigen::Vector2d(axis.z(), -axis.x());
      shape.add_line(wall.name, from - across, to - across);
      shape.add_line(wall.name, from + across, to + across);
    }
  }
}

Shape shape_of(const Rig& rig) {
  Shape shape;
  for (const Wall& wall : rig.walls)
    shape.add_line(wall.name, {wall.from_x, wall.from_z}, {wall.to_x, wall.to_z});
  if (const auto& face = rig.moving_face)
    shape.add_line("piston", {face->left_x, face->face_z}, {face->right_x, face->face_z});
  if (rig.walls.empty()) {
    for (const SceneWall& wall : rig.scene.walls) add_seen(wall, shape);
  }
  return shape;
}

std::optional<Unit> unit_of(std::string_view key) {
  for (const Units units : {Units(length_units), Units(angle_units)}) {
    for (const Unit& unit : units) {
      if (key.size() > unit.suffix.size() && key.ends_with(unit.suffix) &&
          key[key.size() - unit.suffix.size() - 1] == '_')
        return unit;
    }
  }
  return std::nullopt;
}

class Drawer {
 public:
  Drawer(toml::table rig, const RigContext& context) : rig_(std::move(rig)), context_(context) {
    context_.inputs = nullptr;
    context_.notes = nullptr;
    if (context_.particle == nullptr) {
      // Grains are not drawn; those of the smallest sizes get through everywhere
      constexpr double radius = 1.0e-6;  // m
      speck_ = particle_of({.spheres = {{Eigen::Vector3d::Zero(), radius}}, .mass = 1.0e-12}, 1);
      context_.particle = &speck_;
    }
  }

  Rig read(const toml::table& table) const {
    return read_rig(
        TomlSection(std::make_shared<const toml::table>(table), "", "rig"), nullptr, context_);
  }
  std::optional<Rig> try_to_read(const toml::table& table) const {
    try {
      return read(table);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  void take_setting(std::string_view key, const toml::node& value) {
    if (rig_.contains(key) || !value.is_number()) return;
    toml::table with = rig_;
    with.insert(key, value);
    if (try_to_read(with)) rig_ = std::move(with);
  }

  RigDrawing draw();

 private:
  void list_dimensions(const toml::node& node, const Path& path);
  toml::table with(const std::vector<double>& values) const;
  // Places of corners; none where such a rig cannot be, or is drawn with other corners.
  std::optional<std::vector<Eigen::Vector2d>> corners_at(const std::vector<double>& values) const;
  void drop_dimensions_that_do_nothing();
  void take_samples();
  // Which dimensions change a coordinate.
  std::vector<std::size_t> that_change(std::size_t corner, int axis) const;
  std::optional<std::vector<DrawnTerm>> terms_of(std::size_t corner, int axis) const;
  bool fit();

  toml::table rig_;
  RigContext context_;
  Particle speck_;
  Shape shape_;
  RigDrawing drawing_;
  std::vector<std::vector<double>> samples_;
  std::vector<std::vector<Eigen::Vector2d>> sampled_;
};

void Drawer::list_dimensions(const toml::node& node, const Path& path) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) {
      Path longer = path;
      longer.push_back({.key = std::string(key.str())});
      list_dimensions(value, longer);
    }
  } else if (const toml::array* list = node.as_array()) {
    for (std::size_t i = 0; i < list->size(); ++i) {
      Path longer = path;
      longer.push_back({.number = i});
      list_dimensions((*list)[i], longer);
    }
  } else if (node.is_number() && !path.back().key.empty()) {
    const std::string& key = path.back().key;
    if (const auto unit = unit_of(key)) {
      drawing_.dimensions.push_back({.path = path,
                                     .stem = key.substr(0, key.size() - unit->suffix.size() - 1),
                                     .unit = unit->in_si,
                                     .value = *node.value<double>() * unit->in_si,
                                     .form = "plain"});
    }
  }
}

toml::table Drawer::with(const std::vector<double>& values) const {
  toml::table table = rig_;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const DrawnDimension& dimension = drawing_.dimensions[i];
    toml::node* node = &table;
    for (std::size_t depth = 0; depth + 1 < dimension.path.size(); ++depth) {
      const TomlStep& step = dimension.path[depth];
      node =
          step.key.empty() ? node->as_array()->get(step.number) : node->as_table()->get(step.key);
    }
    node->as_table()->insert_or_assign(dimension.path.back().key, values[i] / dimension.unit);
  }
  return table;
}

std::optional<std::vector<Eigen::Vector2d>> Drawer::corners_at(
    const std::vector<double>& values) const {
  const auto rig = try_to_read(with(values));
  if (!rig) return std::nullopt;
  Shape shape = shape_of(*rig);
  if (shape.corners.size() != shape_.corners.size()) return std::nullopt;
  return std::move(shape.corners);
}

std::vector<double> values_of(const std::vector<DrawnDimension>& dimensions) {
  std::vector<double> values;
  for (const DrawnDimension& dimension : dimensions) values.push_back(dimension.value);
  return values;
}

// As far as a dimension is moved to see what it does
double reach_of(double value) { return std::max(0.02 * std::abs(value), 1.0e-4); }

void Drawer::drop_dimensions_that_do_nothing() {
  for (std::size_t i = drawing_.dimensions.size(); i-- > 0;) {
    std::vector<double> values = values_of(drawing_.dimensions);
    values[i] += reach_of(values[i]);
    const auto corners = corners_at(values);
    if (!corners || *corners == shape_.corners)
      drawing_.dimensions.erase(drawing_.dimensions.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void Drawer::take_samples() {
  samples_.clear();
  sampled_.clear();
  constexpr int count = 120;
  std::mt19937 random(1);
  for (int k = 0; k < count; ++k) {
    std::vector<double> values = values_of(drawing_.dimensions);
    for (double& value : values) {
      const double share =
          static_cast<double>(random()) / std::mt19937::max();  // the same anywhere
      value += 5.0 * reach_of(value) * (2.0 * share - 1.0);
    }
    if (auto corners = corners_at(values)) {
      samples_.push_back(std::move(values));
      sampled_.push_back(*std::move(corners));
    }
  }
}

std::vector<std::size_t> Drawer::that_change(std::size_t corner, int axis) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < drawing_.dimensions.size(); ++i) {
    std::vector<double> values = values_of(drawing_.dimensions);
    values[i] += reach_of(values[i]);
    const auto corners = corners_at(values);
    if (corners && (*corners)[corner][axis] != shape_.corners[corner][axis]) found.push_back(i);
  }
  return found;
}

std::optional<std::vector<DrawnTerm>> Drawer::terms_of(std::size_t corner, int axis) const {
  const std::vector<std::size_t> dimensions = that_change(corner, axis);
  std::vector<DrawnTerm> terms = {{1.0, -1, -1}};
  for (std::size_t a = 0; a < dimensions.size(); ++a) {
    terms.push_back({1.0, static_cast<int>(dimensions[a]), -1});
    for (std::size_t b = a; b < dimensions.size(); ++b)
      terms.push_back({1.0, static_cast<int>(dimensions[a]), static_cast<int>(dimensions[b])});
  }
  const auto product = [&](const DrawnTerm& term, const std::vector<double>& values) {
    double result = 1.0;
    for (const int i : {term.first, term.second}) {
      if (i < 0) continue;
      const auto place = static_cast<std::size_t>(i);
      const std::string_view form = drawing_.dimensions[place].form;
      result *= std::find_if(forms.begin(), forms.end(), [&](const Form& one) {
                  return one.name == form;
                })->of(values[place]);
    }
    return result;
  };
  const auto rows = static_cast<Eigen::Index>(samples_.size());
  const auto columns = static_cast<Eigen::Index>(terms.size());
  if (rows < 2 * columns) return std::nullopt;
  Eigen::MatrixXd matrix(rows, columns);
  Eigen::VectorXd wanted(rows);
  for (Eigen::Index r = 0; r < rows; ++r) {
    for (Eigen::Index c = 0; c < columns; ++c) {
      matrix(r, c) =
          product(terms[static_cast<std::size_t>(c)], samples_[static_cast<std::size_t>(r)]);
    }
    wanted[r] = sampled_[static_cast<std::size_t>(r)][corner][axis];
  }
  const Eigen::VectorXd size = matrix.colwise().norm().cwiseMax(1.0e-12);
  const Eigen::VectorXd scaled =
      (matrix * size.cwiseInverse().asDiagonal()).completeOrthogonalDecomposition().solve(wanted);
  const Eigen::VectorXd factors = scaled.cwiseQuotient(size);
  constexpr double exact = 1.0e-9;  // m
  if ((matrix * factors - wanted).cwiseAbs().maxCoeff() > exact) return std::nullopt;
  std::vector<DrawnTerm> kept;
  for (Eigen::Index c = 0; c < columns; ++c) {
    // What never reaches a thousandth of that is rounding
    if (std::abs(factors[c]) * matrix.col(c).cwiseAbs().maxCoeff() < 1.0e-3 * exact) continue;
    kept.push_back(terms[static_cast<std::size_t>(c)]);
    kept.back().factor = factors[c];
  }
  return kept;
}

// With the forms that are set.
bool Drawer::fit() {
  drawing_.corners.clear();
  for (std::size_t corner = 0; corner < shape_.corners.size(); ++corner) {
    auto x = terms_of(corner, 0), z = terms_of(corner, 1);
    if (!x || !z) return false;
    drawing_.corners.push_back({*std::move(x), *std::move(z)});
  }
  return true;
}

RigDrawing Drawer::draw() {
  const Rig rig = read(rig_);
  shape_ = shape_of(rig);
  drawing_.lines = shape_.lines;
  drawing_.circles = shape_.circles;
  list_dimensions(rig_, {});
  drop_dimensions_that_do_nothing();
  take_samples();
  // 1. In which form angles enter: all combinations
  std::vector<std::size_t> angles;
  for (std::size_t i = 0; i < drawing_.dimensions.size(); ++i) {
    const std::string& key = drawing_.dimensions[i].path.back().key;
    if (key.ends_with("_deg") || key.ends_with("_rad")) angles.push_back(i);
  }
  const std::function<bool(std::size_t)> fits = [&](std::size_t next) {
    if (next == angles.size()) return fit();
    return std::any_of(forms.begin(), forms.end(), [&](const Form& form) {
      drawing_.dimensions[angles[next]].form = form.name;
      return fits(next + 1);
    });
  };
  constexpr std::size_t most_angles = 3;
  if (angles.size() > most_angles || !fits(0)) {
    // 2. Where none is exact it is drawn as it is, and cannot be dragged
    drawing_.dimensions.clear();
    drawing_.corners.clear();
    for (const Eigen::Vector2d& corner : shape_.corners)
      drawing_.corners.push_back({{{corner.x(), -1, -1}}, {{corner.y(), -1, -1}}});
  }
  for (DrawnDimension& dimension : drawing_.dimensions) {
    dimension.is_setting =
        std::any_of(rig.settings.begin(), rig.settings.end(), [&](const RigSetting& setting) {
          return dimension.path.size() == 1 && setting.name == dimension.stem;
        });
  }
  for (const auto& [key, value] : rig_) {
    toml::table without = rig_;
    without.erase(key.str());
    if (key.str() != "kind" && try_to_read(without)) drawing_.optional_keys.emplace_back(key.str());
  }
  return drawing_;
}

}  // namespace

RigDrawing draw_rig(const TomlSection& rig,
                    const std::vector<std::string>& settings,
                    const RigContext& context) {
  Drawer drawer(toml::parse(rig.text_without({})), context);
  for (const std::string& text : settings) {
    const toml::table stated = toml::parse(text);
    for (const auto& [key, value] : stated) drawer.take_setting(key.str(), value);
  }
  return drawer.draw();
}

}  // namespace graintruth::datasets
