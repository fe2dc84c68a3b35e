#include "scatmap/brdf/frame_source.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "scatmap/base/error.h"
#include "scatmap/base/number_text.h"
#include "scatmap/base/parallel.h"
#include "scatmap/base/units.h"
#include "scatmap/counts/frame_light.h"
#include "scatmap/counts/frame_steadiness.h"

namespace scatmap {
namespace {

double required(const std::optional<double>& value, const std::filesystem::path& file, const char* key) {
  if (!value) throw Error({file.string() + ": sensor." + key, "is missing", {}, "a number > 0: counts need it"});
  return *value;
}

SensorModel sensor_model(const Measurement& m) {
  const Sensor& s = m.instrument.sensor;
  return {required(s.gain_e_per_dn, m.instrument_file, "gain_e_per_dn"),
          required(s.read_noise_e, m.instrument_file, "read_noise_e"),
          required(s.saturation_dn, m.instrument_file, "saturation_dn"), s.bias_dn, s.linearity};
}

void require_detector_size(int rows, int columns, const std::string& file, const Instrument& instrument) {
  if (rows == instrument.rows && columns == instrument.columns) return;
  throw Error({file, "has the wrong size", std::to_string(columns) + " x " + std::to_string(rows),
               std::to_string(instrument.columns) + " x " + std::to_string(instrument.rows) +
                   " as detector.columns and rows say"});
}

// A file's own word against the measurement's: neither is preferred, the user must decide.
void require_agreement(const std::optional<double>& in_file, double stated, double tolerance, const std::string& where,
                       const char* what) {
  if (in_file && !(std::abs(*in_file - stated) <= tolerance)) {
    throw Error({where, std::string("contradicts ") + what, number_text(*in_file), number_text(stated)});
  }
}

// Enough rows to tell whether frames agree: a beam is smaller than what a sample scatters.
int row_step(int rows, bool beam) { return std::max(1, rows / (beam ? 1000 : 250)); }

bool is_signature(const std::string& role) { return role.starts_with("signature"); }

std::string percent_text(double relative) { return number_text(std::round(1e3 * relative) / 10) + " %"; }

// Several files at a time; of several failures the first in the list is told, whatever the threads did.
std::vector<RecordedFrame> read_in_parallel(const std::vector<std::filesystem::path>& paths) {
  std::vector<RecordedFrame> out(paths.size());
  std::vector<std::exception_ptr> failures(paths.size());
  for_each_index(paths.size(), std::size_t{1}, [&](std::size_t i) {
    try {
      out[i] = read_recorded_frame(paths[i]);
    } catch (...) {
      failures[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
  return out;
}

Grid<Mask> read_bad_pixels(const std::filesystem::path& path, const Instrument& in) {
  if (path.extension() == ".csv") return read_bad_pixel_list(path, in.rows, in.columns);
  const Frame bad = read_frame(path);
  require_detector_size(bad.dn.rows(), bad.dn.columns(), bad.file.string(), in);
  return bad_pixels_from_frame(bad);
}

}  // namespace

FrameSource::FrameSource(const Measurement& measurement)
    : measurement_(measurement), sensor_(sensor_model(measurement)) {
  const Instrument& in = measurement.instrument;
  for (const std::vector<Exposure>* list : {&measurement.signatures, &measurement.exposures}) {
    for (const Exposure& e : *list) ++darks_to_come_[e.darks];
  }
  if (measurement.flat) {
    const Frame flat = read_frame(*measurement.flat);
    require_flat(flat);
    require_detector_size(flat.dn.rows(), flat.dn.columns(), flat.file.string(), in);
    response_.flat = normalised_flat(flat);
    note_flat(flat);
  }
  if (!measurement.bad_pixels) return;
  response_.bad = read_bad_pixels(*measurement.bad_pixels, in);
  if (std::count(response_.bad.begin(), response_.bad.end(), Mask{0}) == 0)
    throw Error({measurement.bad_pixels->string(), "marks every pixel of the detector as bad", {}, {}});
}

void FrameSource::note_flat(const Frame& flat) {
  constexpr double kFactor = 2, kMany = 0.05;
  std::size_t positive = 0, off = 0;
  for (const float v : response_.flat) {
    if (!(v > 0)) continue;
    ++positive;
    if (v < 1 / kFactor || v > kFactor) ++off;
  }
  const bool holds_bias = std::all_of(flat.dn.begin(), flat.dn.end(),
                                      [&](float v) { return !(v > 0 && static_cast<double>(v) < sensor_.bias_dn); });
  if (flat.quantum_dn > 0 && sensor_.bias_dn > 0 && holds_bias)
    notes_.push_back(flat.file.string() + ": holds whole numbers, none below sensor.bias_dn = " +
                     number_text(sensor_.bias_dn) + ": a flat field must be without its dark; was it taken off?");
  if (flat.quantum_dn > 0) raw_flat_dn_ = frame_light(flat.dn).sum_dn / static_cast<double>(flat.dn.size());
  const double share = static_cast<double>(off) / static_cast<double>(positive);
  if (share > kMany)
    notes_.push_back(flat.file.string() + ": " + percent_text(share) +
                     " of its pixels are off its mean by more than a factor of 2: is it a flat field?");
}

// Levels that darks cannot have.
void FrameSource::check_level(const MasterDark& dark, const std::string& role) {
  constexpr double kSigmas = 5;
  const double level = frame_light(dark.level_dn).sum_dn / static_cast<double>(dark.level_dn.size()),
               noise = std::max(1.0, sensor_.read_noise_dn());
  if (raw_flat_dn_ && std::abs(*raw_flat_dn_ - level) < kSigmas * noise)
    throw Error({measurement_.flat->string(), "is at the level of the darks of " + role + ": it shows no light",
                 number_text(std::round(*raw_flat_dn_)) + " DN", "a flat field"});
  if (level < sensor_.bias_dn - kSigmas * noise)
    notes_.push_back("darks of " + role + " lie at " + number_text(std::round(level)) +
                     " DN, below sensor.bias_dn = " + number_text(sensor_.bias_dn) + ": check it");
}

void FrameSource::check(const Frame& f, bool is_dark, double exposure_s) {
  const std::string name = f.file.string();
  is_dark ? require_dark(f) : require_light(f);
  require_detector_size(f.dn.rows(), f.dn.columns(), name, measurement_.instrument);
  require_agreement(f.header.exposure_s, exposure_s, 1e-3 * exposure_s, name + ": EXPTIME",
                    is_dark ? "exposure_s of the frames it is the dark of" : "exposure_s");
  const std::optional<double>& nominal = measurement_.instrument.sensor.header_gain_e_per_dn;
  const double header_gain = nominal.value_or(sensor_.gain_e_per_dn);
  require_agreement(f.header.gain_e_per_dn, header_gain, 0.01 * header_gain, name + ": EGAIN",
                    nominal ? "sensor.header_gain_e_per_dn"
                            : "sensor.gain_e_per_dn (a measured gain beside what the frames say: "
                              "sensor.header_gain_e_per_dn)");
  if (f.header.row_order) {
    if (row_order_.empty()) {
      row_order_ = *f.header.row_order;
      row_order_file_ = name;
    }
    // Rows the other way round would change the sign of phi.
    if (row_order_ != *f.header.row_order) {
      throw Error({name + ": ROWORDER", "differs from that of " + row_order_file_, *f.header.row_order, row_order_});
    }
  }
}

std::vector<Frame> FrameSource::read_all(const Exposure& e, bool are_darks, std::vector<InputRecord>& records) {
  const std::vector<std::filesystem::path>& paths = are_darks ? e.darks : e.frames;
  for (const std::filesystem::path& path : paths) {
    std::error_code other;  // is for the reader to tell
    if (std::filesystem::status(path, other).type() == std::filesystem::file_type::not_found)
      throw Error({path.string(), "does not exist", {}, (are_darks ? "a dark of " : "the frame of ") + e.where});
  }
  std::vector<Frame> frames;
  for (RecordedFrame& read : read_in_parallel(paths)) {
    check(read.frame, are_darks, e.exposure_s);
    require_new(read.record, read.frame.file);
    frames.push_back(std::move(read.frame));
    records.push_back(std::move(read.record));
  }
  return frames;
}

// A copy adds no knowledge, and would make the noise seem smaller than it is.
void FrameSource::require_new(const InputRecord& record, const std::filesystem::path& path) {
  const auto [at, is_new] = seen_.emplace(record.sha256, path);
  if (!is_new && at->second != path)
    throw Error({path.string(), "has the very same bytes as " + at->second.string(), {}, "a frame of its own"});
}

namespace {

constexpr double kWander = 0.2;  // of the read noise, all pixels together

// Frames of one exposure see the same light. What the sensor's offset may wander by is no light.
// @param allowed  relative
std::optional<std::string> light_that_differs(const std::vector<Frame>& frames, const std::vector<double>& net_dn,
                                              double allowed, double wander_dn) {
  const auto [least, most] = std::minmax_element(net_dn.begin(), net_dn.end());
  const double difference = *most - *least;
  if (!(difference > wander_dn && difference > allowed * *most)) return std::nullopt;
  const auto name = [&](auto at) { return frames[static_cast<std::size_t>(at - net_dn.begin())].file.string(); };
  return name(least) + " shows " + percent_text(difference / *most) + " less light than " + name(most);
}

std::optional<std::string> clipping(const Frame& frame, const FrameLight& light, double dark_dn,
                                    const SensorModel& sensor) {
  constexpr std::size_t kMany = 10;
  constexpr double kAboveNoise = 100;
  if (light.at_largest < kMany || light.largest_dn >= sensor.saturation_dn ||
      !(light.largest_dn > dark_dn + kAboveNoise * sensor.read_noise_dn()))
    return std::nullopt;
  return frame.file.string() + ": " + std::to_string(light.at_largest) + " pixels hold the very same largest value, " +
         number_text(light.largest_dn) +
         " DN: it may clip there, below saturation_dn = " + number_text(sensor.saturation_dn);
}

}  // namespace

void FrameSource::note_light(const std::vector<Frame>& frames, const MasterDark& dark, const std::string& role,
                             bool bright) {
  const auto pixels = static_cast<double>(dark.level_dn.size());
  const double dark_dn = frame_light(dark.level_dn).sum_dn;
  std::vector<double> net_dn;
  for (const Frame& frame : frames) {
    const FrameLight light = frame_light(frame.dn);
    if (light.at_largest == 0) throw Error({frame.file.string(), "holds no number: every pixel is NaN", {}, {}});
    net_dn.push_back(light.sum_dn - dark_dn);
    if (const auto note = clipping(frame, light, dark_dn / pixels, sensor_)) notes_.push_back(*note);
  }
  constexpr double kAllowed = 0.1;
  if (bright) return;
  if (const auto note = light_that_differs(frames, net_dn, std::max(kAllowed, 3 * measurement_.laser_drift),
                                           kWander * sensor_.read_noise_dn() * pixels))
    notes_.push_back(role + ": " + *note);
}

// Where there is much light, less suffices to tell.
FrameSource::Changes FrameSource::note_changes(const std::vector<Frame>& frames, const MasterDark& dark,
                                               const std::string& role) {
  constexpr std::size_t kFew = 5;
  if (frames.size() < 2) return {false, false};
  const FrameChanges found =
      frame_changes(frames, dark, sensor_, row_step(frames.front().dn.rows(), is_signature(role)));
  if (found.pixels <= kFew) return {false, false};
  std::vector<double> net_dn;
  for (const FrameChange& f : found.of_frame) net_dn.push_back(f.net_dn);
  const auto pixels = static_cast<double>(found.pixels);
  constexpr double kSteady = 0.01, kSigmas = 6;  // relative; of the sums' noise
  if (const auto note = light_that_differs(frames, net_dn, std::max(kSteady, 3 * measurement_.laser_drift),
                                           kWander * sensor_.read_noise_dn() * pixels + kSigmas * found.u_net_dn))
    notes_.push_back(role + ": " + *note + " where there is light");
  constexpr double kMany = 0.01;
  const auto most = std::max_element(found.of_frame.begin(), found.of_frame.end(),
                                     [](const auto& a, const auto& b) { return a.differing < b.differing; });
  const auto differing = static_cast<double>(most->differing);
  if (most->differing <= kFew || !(differing > kMany * pixels)) return {true, false};
  notes_.push_back(role + ": " + percent_text(differing / pixels) + " of the bright pixels of " +
                   frames[static_cast<std::size_t>(most - found.of_frame.begin())].file.string() +
                   " differ from the frames' mean by more than noise and drift: did the beam or the scene move?");
  return {true, true};
}

std::shared_ptr<const FrameSource::Dark> FrameSource::dark_of(const Exposure& e, double quantum_dn) {
  if (e.stated_dark) {
    const Instrument& in = measurement_.instrument;
    return std::make_shared<Dark>(
        Dark{stated_dark(e.stated_dark->level_dn, e.stated_dark->u_level_dn, in.rows, in.columns, quantum_dn, sensor_),
             {},
             groups_++});
  }
  std::shared_ptr<const Dark>& slot = darks_[e.darks];
  if (!slot) {
    std::vector<InputRecord> records;
    const std::vector<Frame> frames = read_all(e, true, records);
    slot = std::make_shared<Dark>(Dark{combine_darks(frames, sensor_), std::move(records), groups_++});
  }
  if (--darks_to_come_.at(e.darks) > 0) return slot;
  return std::exchange(slot, nullptr);
}

FrameSource::Raw FrameSource::read_exposure(const Exposure& e, const std::string& role) {
  ExposureRecord record{role, e.exposure_s, e.filters, {}, {}};
  // Darks come first: once they are combined, their memory serves the frames.
  std::shared_ptr<const Dark> dark = e.stated_dark ? nullptr : dark_of(e, 0);
  std::vector<Frame> frames = read_all(e, false, record.frames);
  if (!dark) dark = dark_of(e, frames.front().quantum_dn);
  const bool is_sample = !is_signature(role);
  for (const Frame& f : frames) {
    constexpr double kSameAngle_deg = 1e-3;
    const std::string name = f.file.string();
    if (is_sample)
      require_agreement(f.header.stage_deg, measurement_.pose.stage_rad * kDegPerRad, kSameAngle_deg,
                        name + ": STAGEDEG", "stage_deg");
    if (is_sample || e.arm_rad)
      require_agreement(f.header.arm_deg, (is_sample ? measurement_.pose.arm_rad : *e.arm_rad) * kDegPerRad,
                        kSameAngle_deg, name + ": ARMDEG", is_sample ? "arm_deg" : "arm_deg of the signature");
  }
  record.darks = dark->records;
  check_level(dark->master, role);
  const Changes changes = note_changes(frames, dark->master, role);
  note_light(frames, dark->master, role, changes.bright);
  const double pooled = dark->master.pooled_from_frames ? std::sqrt(dark->master.pooled_variance_dn2) : 0;
  return {std::move(frames), std::move(dark), pooled, std::move(record), changes.moved};
}

namespace {

// The mean of frames taken one by one: none of their values is an outlier of the others.
template <class Reduce>
Counts mean_of_single(const std::vector<Frame>& frames, const Reduce& reduced) {
  Counts out = reduced(frames.front());
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const Counts more = reduced(frames[k]);
    for (std::size_t i = 0; i < out.mask.size(); ++i) {
      out.rate_dn_per_s[i] += more.rate_dn_per_s[i];
      out.mask[i] |= more.mask[i];
    }
    out.saturated_pixels += more.saturated_pixels;
  }
  const auto count = static_cast<double>(frames.size());
  for (std::size_t i = 0; i < out.mask.size(); ++i) {
    out.rate_dn_per_s[i] /= count;
    out.frame_floor[i] /= static_cast<float>(count);
    out.shot[i] /= static_cast<float>(count);
  }
  return out;
}

}  // namespace

FrameSource::Reduced FrameSource::reduce_exposure(const Exposure& e, const std::string& role) {
  Raw raw = read_exposure(e, role);
  const auto reduced = [&](std::span<const Frame> frames) {
    return reduce(frames, raw.dark->master, sensor_, response_, e.exposure_s);
  };
  // All of a beam counts, wherever it went.
  const bool one_by_one = raw.moved && is_signature(role);
  Counts counts = one_by_one ? mean_of_single(raw.frames,
                                              [&](const Frame& f) {
                                                return reduced({&f, 1});
                                              })
                             : reduced(raw.frames);
  return {std::move(counts), raw.dark->group, raw.pooled_dark_noise_dn, std::move(raw.record)};
}

}  // namespace scatmap
