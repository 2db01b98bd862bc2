// Film files as cameras, phones and cutting programs leave them, written by FFmpeg's libraries:
// with notes, stamps and streams as a test wants them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

namespace graintruth::tracking {

struct FilmToWrite {
  std::vector<cv::Mat> pictures;                      // of even width and height
  std::vector<std::int64_t> stamps;                   // ms; pictures before 0 are hidden
  std::optional<std::array<std::int32_t, 9>> matrix;  // of display
  bool still_before = false;                          // a stream of a single picture
  bool sound_before = false;
  int films = 1;            // the later ones show the pictures upside down
  std::set<int> spoiled;    // pictures whose data are lost
  bool index_first = true;  // of mp4 and mov
};

class FilmOnDisk {
 public:
  // Motion JPEG in a container that the name's ending tells.
  FilmOnDisk(const std::filesystem::path& file, const FilmToWrite& film) {
    av_log_set_level(AV_LOG_QUIET);
    check(avformat_alloc_output_context2(&format_, nullptr, nullptr, file.c_str()));
    if (film.sound_before) add_sound();
    if (film.still_before) add_film(film.pictures.front().size());
    for (int k = 0; k < film.films; ++k) {
      add_film(film.pictures.front().size());
      if (film.matrix) note(*film.matrix);
    }
    check(avio_open(&format_->pb, file.c_str(), AVIO_FLAG_WRITE));
    AVDictionary* options = nullptr;
    if (film.index_first) av_dict_set(&options, "movflags", "faststart", 0);
    check(avformat_write_header(format_, &options));
    av_dict_free(&options);
    if (film.sound_before) write_sound(film.stamps.back());
    const int first = film.sound_before + film.still_before;
    if (film.still_before) write(first - 1, film.pictures.front(), 0, false);
    for (std::size_t k = 0; k < film.pictures.size(); ++k) {
      for (int other = 0; other < film.films; ++other) {
        cv::Mat picture = film.pictures[k];
        if (other > 0) cv::flip(film.pictures[k], picture, 0);
        write(first + other, picture, film.stamps[k], film.spoiled.contains(static_cast<int>(k)));
      }
    }
    check(av_write_trailer(format_));
  }
  ~FilmOnDisk() {
    for (AVCodecContext*& coder : coders_) avcodec_free_context(&coder);
    avio_closep(&format_->pb);
    avformat_free_context(format_);
  }
  FilmOnDisk(const FilmOnDisk&) = delete;
  FilmOnDisk& operator=(const FilmOnDisk&) = delete;

 private:
  static void check(int status) {
    if (status < 0) throw std::runtime_error("FFmpeg cannot write this film");
  }

  void add_film(const cv::Size& size) {
    const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_MJPEG);
    AVCodecContext* coder = coders_.emplace_back(avcodec_alloc_context3(codec));
    coder->width = size.width;
    coder->height = size.height;
    coder->pix_fmt = AV_PIX_FMT_YUVJ420P;
    coder->time_base = {1, 1000};
    coder->flags |= AV_CODEC_FLAG_QSCALE;
    coder->global_quality = 2 * FF_QP2LAMBDA;
    check(avcodec_open2(coder, codec, nullptr));
    AVStream* stream = avformat_new_stream(format_, nullptr);
    stream->time_base = coder->time_base;
    check(avcodec_parameters_from_context(stream->codecpar, coder));
  }

  void add_sound() {
    coders_.push_back(nullptr);
    AVStream* stream = avformat_new_stream(format_, nullptr);
    stream->time_base = {1, 8000};
    stream->codecpar->codec_type = AVMEDIA_TYPE_AUDIO;
    stream->codecpar->codec_id = AV_CODEC_ID_PCM_S16LE;
    stream->codecpar->sample_rate = 8000;
    stream->codecpar->bits_per_coded_sample = 16;
    stream->codecpar->block_align = 2;
    stream->codecpar->ch_layout = AV_CHANNEL_LAYOUT_MONO;
  }

  void note(const std::array<std::int32_t, 9>& matrix) {
    AVStream* stream = format_->streams[format_->nb_streams - 1];
    auto* bytes = av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, sizeof(matrix));
    std::copy_n(reinterpret_cast<const std::uint8_t*>(matrix.data()), sizeof(matrix), bytes);
  }

  void write_sound(std::int64_t until) {
    AVPacket* packet = av_packet_alloc();
    check(av_new_packet(packet, static_cast<int>(16 * std::max<std::int64_t>(1, until))));
    std::fill_n(packet->data, packet->size, 0);
    packet->pts = packet->dts = 0;
    packet->duration = packet->size / 2;
    check(av_interleaved_write_frame(format_, packet));
    av_packet_free(&packet);
  }

  void write(int stream, const cv::Mat& picture, std::int64_t stamp, bool is_spoiled) {
    AVCodecContext* coder = coders_[static_cast<std::size_t>(stream)];
    AVFrame* frame = av_frame_alloc();
    frame->width = picture.cols;
    frame->height = picture.rows;
    frame->format = coder->pix_fmt;
    frame->pts = stamp;
    frame->quality = coder->global_quality;
    check(av_frame_get_buffer(frame, 0));
    SwsContext* scaler = sws_getContext(picture.cols,
                                        picture.rows,
                                        AV_PIX_FMT_BGR24,
                                        picture.cols,
                                        picture.rows,
                                        coder->pix_fmt,
                                        SWS_BICUBIC,
                                        nullptr,
                                        nullptr,
                                        nullptr);
    const std::uint8_t* rows = picture.data;
    const int step = static_cast<int>(picture.step);
    sws_scale(scaler, &rows, &step, 0, picture.rows, frame->data, frame->linesize);
    sws_freeContext(scaler);
    check(avcodec_send_frame(coder, frame));
    av_frame_free(&frame);
    AVPacket* packet = av_packet_alloc();
    check(avcodec_receive_packet(coder, packet));
    if (is_spoiled) std::fill_n(packet->data, packet->size, 0);
    packet->stream_index = stream;
    packet->duration = 20;
    av_packet_rescale_ts(packet, coder->time_base, format_->streams[stream]->time_base);
    check(av_interleaved_write_frame(format_, packet));
    av_packet_free(&packet);
  }

  AVFormatContext* format_ = nullptr;
  std::vector<AVCodecContext*> coders_;  // none for sound
};

}  // namespace graintruth::tracking
