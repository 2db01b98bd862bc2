#include "tracking/film/film_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <string>

#include "datasets/store/input_error.h"
#include "tracking/median.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libswscale/swscale.h>
}

namespace graintruth::tracking {

using datasets::InputError;

namespace {

// A container may count a frame or two more than it shows.
constexpr double tolerated_missing_share = 0.02;
constexpr int tolerated_missing_frames = 2;

template <auto Free>
struct FreedThrough {
  template <class T>
  void operator()(T* pointer) const {
    Free(&pointer);
  }
};
using Format = std::unique_ptr<AVFormatContext, FreedThrough<avformat_close_input>>;
using Codec = std::unique_ptr<AVCodecContext, FreedThrough<avcodec_free_context>>;
using Packet = std::unique_ptr<AVPacket, FreedThrough<av_packet_free>>;
using Frame = std::unique_ptr<AVFrame, FreedThrough<av_frame_free>>;
struct FreedScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using Scaler = std::unique_ptr<SwsContext, FreedScaler>;

std::uint64_t big_endian(const unsigned char* bytes, std::size_t count) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < count; ++i) number = number << 8 | bytes[i];
  return number;
}

// Whether a file that is a row of boxes (mp4, mov) ends within one of them; nothing where it is
// not.
std::optional<bool> ends_within_box(const std::filesystem::path& file) {
  constexpr std::size_t short_header = 8, long_header = 16;  // bytes: size, name, size again
  const std::uint64_t end = std::filesystem::file_size(file);
  std::ifstream in(file, std::ios::binary);
  std::uint64_t at = 0;
  while (at < end) {
    std::array<unsigned char, long_header> header{};
    in.clear();
    in.seekg(static_cast<std::streamoff>(at));
    in.read(reinterpret_cast<char*>(header.data()), header.size());
    const std::string name(header.begin() + 4, header.begin() + short_header);
    if (at == 0 && name != "ftyp") return std::nullopt;
    if (end - at < short_header) return true;
    std::uint64_t size = big_endian(header.data(), 4);
    if (size == 0) return false;  // up to the end
    if (size == 1) size = big_endian(header.data() + short_header, 8);
    if (size < short_header || size > end - at) return true;
    at += size;
  }
  return false;
}

Format open_format(const std::filesystem::path& file) {
  av_log_set_level(AV_LOG_QUIET);  // what is wrong with a film is said in our own sentences
  AVFormatContext* opened = nullptr;
  // Without "file:" a name such as "12:30.mp4" would be a protocol
  const std::string name = "file:" + file.string();
  const bool is_open = avformat_open_input(&opened, name.c_str(), nullptr, nullptr) == 0;
  Format format(opened);
  if (!is_open && ends_within_box(file).value_or(false)) {
    throw InputError(fmt::format(
        "{}: cannot be opened as a film: it is cut off, and its index, which stands at the end of "
        "such files, is missing; copy or record it again",
        file.string()));
  }
  if (!is_open || avformat_find_stream_info(format.get(), nullptr) < 0) {
    throw InputError(
        fmt::format("{}: cannot be opened as a film (cut off, or not a video); copy it again or "
                    "convert it to mp4",
                    file.string()));
  }
  return format;
}

// Pictures drawn with letters, as which any text file can be read.
bool is_text(AVCodecID codec) {
  return codec == AV_CODEC_ID_ANSI || codec == AV_CODEC_ID_BINTEXT || codec == AV_CODEC_ID_XBIN ||
         codec == AV_CODEC_ID_IDF;
}

// The streams of moving pictures: neither covers nor previews, nor a still beside a film.
std::vector<int> films_in(const AVFormatContext& format) {
  std::vector<int> films;
  bool has_moving = false;
  const auto is_still = [&](int i) { return format.streams[i]->nb_frames == 1; };
  for (int i = 0; i < static_cast<int>(format.nb_streams); ++i) {
    const AVStream& stream = *format.streams[i];
    constexpr int no_film = AV_DISPOSITION_ATTACHED_PIC | AV_DISPOSITION_TIMED_THUMBNAILS;
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO || (stream.disposition & no_film) != 0 ||
        is_text(stream.codecpar->codec_id))
      continue;
    films.push_back(i);
    has_moving = has_moving || !is_still(i);
  }
  if (has_moving) std::erase_if(films, is_still);
  return films;
}

[[noreturn]] void refuse_without_film(const AVFormatContext& format,
                                      const std::filesystem::path& file) {
  bool has_sound = false, has_cover = false;
  for (unsigned i = 0; i < format.nb_streams; ++i) {
    const AVStream& stream = *format.streams[i];
    has_sound = has_sound || stream.codecpar->codec_type == AVMEDIA_TYPE_AUDIO;
    has_cover = has_cover || (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) != 0;
  }
  if (!has_sound) {
    throw InputError(fmt::format(
        "{}: cannot be opened as a film: it holds no moving pictures; give a video file",
        file.string()));
  }
  throw InputError(
      fmt::format("{}: cannot be opened as a film: it holds sound{} but no moving pictures; give "
                  "the file of the film",
                  file.string(),
                  has_cover ? " and a cover" : ""));
}

Turn turn_of(const AVStream& stream, const std::filesystem::path& file) {
  const std::uint8_t* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (data == nullptr) return {};
  std::array<std::int32_t, 9> matrix{};
  std::copy_n(data, sizeof(matrix), reinterpret_cast<std::uint8_t*>(matrix.data()));
  // A stored place (column, row) is shown at (a column + c row, b column + d row)
  const double a = matrix[0], b = matrix[1], c = matrix[3], d = matrix[4];
  if (a * d == b * c) return {};    // says nothing
  constexpr double slanted = 0.02;  // about a degree, as players take it
  const double along = std::min(std::abs(a), std::abs(d));
  const double across = std::min(std::abs(b), std::abs(c));
  if (std::max(std::abs(b), std::abs(c)) < slanted * along)
    return {.flips_x = a < 0.0, .flips_y = d < 0.0};
  if (std::max(std::abs(a), std::abs(d)) < slanted * across)
    return {.swaps_axes = true, .flips_x = c < 0.0, .flips_y = b < 0.0};
  throw InputError(
      fmt::format("{}: the file says that its pictures are shown turned by {:.0f} degrees, but "
                  "films are only turned by quarters; level the camera, or take that note out of "
                  "the file",
                  file.string(),
                  std::atan2(b, a) * 180.0 / std::numbers::pi));
}

// Whether a file in RIFF format (AVI) is shorter than it says at its beginning.
bool is_shorter_than_riff(const std::filesystem::path& file) {
  std::array<unsigned char, 8> start{};
  std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(start.data()), start.size());
  std::uintmax_t size = start.size();
  for (std::size_t i = 0; i < 4; ++i) size += std::uintmax_t{start[4 + i]} << (8 * i);
  return std::filesystem::file_size(file) < size;
}

// What header or index announce beyond the pictures that were found, which end at `last_end`, s;
// `indexed` are the entries of the index before anything was read.
void compare_with_announced(AVFormatContext& format,
                            AVStream& stream,
                            const std::filesystem::path& file,
                            int indexed,
                            double last_end,
                            Container& found) {
  found.announced = found.shown;
  const std::string name = format.iformat->name;
  // 1. An index of every picture, with those that players do not show
  if (name.find("mp4") != std::string::npos) {
    int count = 0;
    for (int i = 0; i < avformat_index_get_entries_count(&stream); ++i)
      count += (avformat_index_get_entry(&stream, i)->flags & AVINDEX_DISCARD_FRAME) == 0;
    found.announced = std::max(found.shown, count);
    // In fragments, as cameras write that may be switched off, each has its own index
    const bool has_more_indices = avformat_index_get_entries_count(&stream) != indexed;
    found.ends_early =
        count > found.shown || (has_more_indices && ends_within_box(file).value_or(false));
    return;
  }
  // 2. An index, which may be lost, and a number of pictures, which counts empty ones too
  if (name == "avi") {
    found.ends_early = is_shorter_than_riff(file);
    const int count = found.ends_early ? static_cast<int>(stream.nb_frames) : indexed;
    found.announced = std::max(found.shown, count);
    return;
  }
  // 3. How long the whole lasts, if the header says so and nobody guessed
  const bool is_told = format.duration != AV_NOPTS_VALUE && found.frame_rate > 0.0 &&
                       format.duration_estimation_method == AVFMT_DURATION_FROM_STREAM;
  if (!is_told) return;
  const double start =
      format.start_time != AV_NOPTS_VALUE ? static_cast<double>(format.start_time) : 0.0;
  const double end = (start + static_cast<double>(format.duration)) / AV_TIME_BASE;
  Container told = found;
  told.announced += std::max(0, static_cast<int>((end - last_end) * found.frame_rate));
  told.ends_early = told.announced > told.shown;
  if (told.is_cut_off()) found = told;
}

}  // namespace

int Turn::degrees() const {
  if (!swaps_axes) return flips_y ? 180 : 0;
  return flips_y ? 270 : 90;
}

cv::Mat Turn::of(const cv::Mat& stored) const {
  if (is_none()) return stored;
  cv::Mat shown = stored;
  if (swaps_axes) cv::transpose(stored, shown);
  if (flips_x || flips_y) {
    cv::Mat flipped;
    cv::flip(shown, flipped, flips_x && flips_y ? -1 : flips_x ? 1 : 0);
    shown = flipped;
  }
  return shown;
}

bool Container::is_cut_off() const {
  // Who knows that it ends early, but not how much is lacking, cannot call that little
  return ends_early && (announced == shown || are_too_many(announced - shown, announced));
}

bool Container::has_holes() const {
  return !ends_early && are_too_many(announced - shown, announced);
}

bool are_too_many(int lacking, int frames) {
  return lacking > std::max<double>(tolerated_missing_frames, tolerated_missing_share * frames);
}

std::vector<int> uneven_steps(const Container& container) {
  constexpr double rounding = 1.2e-3;   // s: some count in milliseconds
  constexpr double least_share = 0.02;  // of a step
  constexpr double large_share = 0.3;   // of a step, whatever the rounding
  std::vector<double> steps;
  for (std::size_t k = 1; k < container.times.size(); ++k)
    steps.push_back(container.times[k] - container.times[k - 1]);
  const double usual = median(steps);
  // A step of several ticks may be one too short or too long
  const double tick = usual > 1.5 * container.tick ? 1.05 * container.tick : 0.0;
  const double tolerance =
      std::max(tick, std::min(large_share * usual, std::max(rounding, least_share * usual)));
  std::vector<int> uneven;
  for (std::size_t k = 0; k < steps.size(); ++k)
    if (std::abs(steps[k] - usual) > tolerance) uneven.push_back(static_cast<int>(k) + 1);
  return uneven;
}

struct FilmFile::Streams {
  std::filesystem::path file;
  Format format;
  int stream = 0;
  int films = 0;
  Turn turn;
  Codec codec;
  Packet packet{av_packet_alloc()};
  Frame frame{av_frame_alloc()}, converted{av_frame_alloc()};
  Scaler scaler;
  // Once the file was listed
  std::optional<Container> container;
  std::vector<std::int64_t> stamps;  // ticks; of the pictures that are shown, in order
  long whole_packets = 0;            // of the film, before the file ends
  // Of reading
  long packets_read = 0;
  int last_place = -1;
  int places_a_picture = 1;  // two where each field of a picture has its own place
  int refused_packets = 0;

  explicit Streams(const std::filesystem::path& path) : file(path), format(open_format(path)) {
    const std::vector<int> found = films_in(*format);
    if (found.empty()) refuse_without_film(*format, file);
    films = static_cast<int>(found.size());
    stream = found.front();
    turn = turn_of(film(), file);
    open_codec();
  }

  AVStream& film() const { return *format->streams[stream]; }

  void open_codec() {
    const AVCodecParameters& coded = *film().codecpar;
    const AVCodec* decoder = avcodec_find_decoder(coded.codec_id);
    if (coded.codec_id == AV_CODEC_ID_NONE) {
      throw InputError(fmt::format(
          "{}: cannot be opened as a film: it does not say how its pictures are coded; copy or "
          "record it again",
          file.string()));
    }
    codec.reset(avcodec_alloc_context3(decoder));
    codec->thread_count = 0;  // as many as there are processors
    if (decoder == nullptr || avcodec_parameters_to_context(codec.get(), &coded) < 0 ||
        avcodec_open2(codec.get(), decoder, nullptr) < 0) {
      throw InputError(
          fmt::format("{}: the film is coded as '{}', which cannot be decoded here; convert it to "
                      "mp4 (H.264)",
                      file.string(),
                      avcodec_get_name(coded.codec_id)));
    }
  }

  // By a second pass over the file, so that the first one goes on where it is.
  void list() {
    const Format whole = open_format(file);
    AVStream& listed = *whole->streams[stream];
    const double tick = av_q2d(listed.time_base);
    Container& says = container.emplace();
    says.films = films;
    says.turn = turn;
    says.width = listed.codecpar->width;
    says.height = listed.codecpar->height;
    says.tick = tick;
    const int indexed = avformat_index_get_entries_count(&listed);
    bool has_stamps = true;
    double last_end = 0.0, last_of_film = 0.0;  // s
    for (; av_read_frame(whole.get(), packet.get()) >= 0; av_packet_unref(packet.get())) {
      const AVPacket& read = *packet;
      const std::int64_t stamp = read.pts != AV_NOPTS_VALUE ? read.pts : read.dts;
      if (stamp != AV_NOPTS_VALUE) {
        last_end = std::max(last_end,
                            static_cast<double>(stamp + read.duration) *
                                av_q2d(whole->streams[read.stream_index]->time_base));
      }
      if (read.stream_index != stream) continue;
      // Shorter than it should be: the file ends within it
      const bool is_partial = (read.flags & AV_PKT_FLAG_CORRUPT) != 0 && avio_feof(whole->pb) != 0;
      if (is_partial) continue;
      ++whole_packets;
      if ((read.flags & AV_PKT_FLAG_DISCARD) != 0) continue;
      ++says.shown;
      has_stamps = has_stamps && read.pts != AV_NOPTS_VALUE;
      stamps.push_back(read.pts);
      if (stamp != AV_NOPTS_VALUE)
        last_of_film = std::max(last_of_film, static_cast<double>(stamp) * tick);
    }
    if (!has_stamps) stamps.clear();
    std::sort(stamps.begin(), stamps.end());
    for (const std::int64_t stamp : stamps)
      says.times.push_back(static_cast<double>(stamp - stamps.front()) * tick);
    says.frame_rate = usual_rate(says, listed);
    if (says.frame_rate > 0.0) last_end = std::max(last_end, last_of_film + 1.0 / says.frame_rate);
    compare_with_announced(*whole, listed, file, indexed, last_end, says);
  }

  static double usual_rate(const Container& says, const AVStream& listed) {
    if (says.times.size() < 2 || !(says.times.back() > 0.0))
      return listed.avg_frame_rate.den > 0 ? av_q2d(listed.avg_frame_rate) : 0.0;
    if (uneven_steps(says).empty())
      return static_cast<double>(says.times.size() - 1) / says.times.back();
    std::vector<double> steps;
    for (std::size_t k = 1; k < says.times.size(); ++k)
      steps.push_back(says.times[k] - says.times[k - 1]);
    const double usual = median(steps);
    return usual > 0.0 ? 1.0 / usual : 0.0;
  }

  // The next packet of the film to the decoder; nothing after the last.
  void feed() {
    while (av_read_frame(format.get(), packet.get()) >= 0) {
      const bool is_ours = packet->stream_index == stream;
      if (is_ours && (!container || ++packets_read <= whole_packets)) {
        refused_packets += avcodec_send_packet(codec.get(), packet.get()) < 0;
        av_packet_unref(packet.get());
        return;
      }
      av_packet_unref(packet.get());
    }
    avcodec_send_packet(codec.get(), nullptr);
  }

  bool decode() {
    constexpr int hopeless = 1000;  // complaints in a row that no packet answers
    for (int complaints = 0; complaints < hopeless; ++complaints) {
      const int status = avcodec_receive_frame(codec.get(), frame.get());
      if (status == 0) return true;
      if (status == AVERROR_EOF) return false;
      if (status == AVERROR(EAGAIN)) {
        feed();
        complaints = 0;
      } else {
        ++refused_packets;
      }
    }
    return false;
  }

  int place_of(const AVFrame& decoded) {
    int place = last_place + 1;
    if (!stamps.empty() && decoded.best_effort_timestamp != AV_NOPTS_VALUE) {
      const auto at = std::lower_bound(stamps.begin(), stamps.end(), decoded.best_effort_timestamp);
      if (at != stamps.end() && *at == decoded.best_effort_timestamp)
        place = std::max(place, static_cast<int>(at - stamps.begin()));
    }
    // Some containers hold the fields of an interlaced picture one by one
    if (last_place == 0 && place == 2 && decoded.interlaced_frame != 0) places_a_picture = 2;
    last_place = place;
    return place / places_a_picture;
  }

  cv::Mat picture_of(const AVFrame& decoded) {
    const auto format_of = static_cast<AVPixelFormat>(decoded.format);
    scaler.reset(sws_getCachedContext(scaler.release(),
                                      decoded.width,
                                      decoded.height,
                                      format_of,
                                      decoded.width,
                                      decoded.height,
                                      AV_PIX_FMT_BGR24,
                                      SWS_BICUBIC,
                                      nullptr,
                                      nullptr,
                                      nullptr));
    if (converted->width != decoded.width || converted->height != decoded.height) {
      av_frame_unref(converted.get());
      converted->format = AV_PIX_FMT_BGR24;
      converted->width = decoded.width;
      converted->height = decoded.height;
      constexpr int alignment = 32;  // bytes, of rows
      if (av_frame_get_buffer(converted.get(), alignment) < 0) throw std::bad_alloc();
    }
    if (!scaler) {
      throw InputError(
          fmt::format("{}: the colours of its pictures cannot be read; convert the film to mp4",
                      file.string()));
    }
    sws_scale(scaler.get(),
              decoded.data,
              decoded.linesize,
              0,
              decoded.height,
              converted->data,
              converted->linesize);
    return cv::Mat(decoded.height,
                   decoded.width,
                   CV_8UC3,
                   converted->data[0],
                   static_cast<std::size_t>(converted->linesize[0]))
        .clone();
  }
};

FilmFile::FilmFile(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file))
    throw InputError(
        fmt::format("{}: the film does not exist; give the path of a video file", file.string()));
  if (std::filesystem::is_directory(file))
    throw InputError(fmt::format(
        "{}: is a folder without pictures; give the path of a video file, or of pictures",
        file.string()));
  if (std::filesystem::file_size(file) == 0)
    throw InputError(fmt::format("{}: the file is empty; copy the film again", file.string()));
  streams_ = std::make_unique<Streams>(file);
}

FilmFile::~FilmFile() = default;
FilmFile::FilmFile(FilmFile&&) noexcept = default;
FilmFile& FilmFile::operator=(FilmFile&&) noexcept = default;

const Container& FilmFile::container() {
  if (!streams_->container) streams_->list();
  return *streams_->container;
}

int FilmFile::refused_packets() const { return streams_->refused_packets; }

bool FilmFile::read(StoredPicture& next) {
  if (!streams_->decode()) return false;
  const AVFrame& decoded = *streams_->frame;
  next.place = streams_->place_of(decoded);
  next.is_patched = decoded.decode_error_flags != 0 || (decoded.flags & AV_FRAME_FLAG_CORRUPT) != 0;
  next.picture = streams_->picture_of(decoded);
  av_frame_unref(streams_->frame.get());
  return true;
}

}  // namespace graintruth::tracking
