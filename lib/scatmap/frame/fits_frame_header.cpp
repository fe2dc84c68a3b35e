#include "scatmap/frame/fits_frame_header.h"

#include "scatmap/base/error.h"

namespace scatmap {
namespace {

enum class Least { kZero, kAboveZero };

std::optional<double> bounded(const FitsHeader& header, const char* key, Least least) {
  const auto value = header.number(key);
  if (!value || *value > 0 || (*value == 0 && least == Least::kZero)) return value;
  const FitsCard& card = *header.find(key);
  throw Error({header.where(card), "is out of range", card.value, least == Least::kZero ? ">= 0" : "> 0"});
}

// Cards that other programs fill as they like: what is no text says nothing.
std::optional<std::string> text_if_any(const FitsHeader& header, const char* key) {
  const FitsCard* card = header.find(key);
  return card != nullptr && card->quoted && !card->value.empty() ? std::optional(card->value) : std::nullopt;
}

std::optional<std::string> row_order(const FitsHeader& header) {
  const auto order = header.text("ROWORDER");
  if (order && *order != "TOP-DOWN" && *order != "BOTTOM-UP") {
    throw Error({header.where(*header.find("ROWORDER")), "is not a row order", *order, "TOP-DOWN or BOTTOM-UP"});
  }
  return order;
}

}  // namespace

FrameHeader fits_frame_header(const FitsHeader& header) {
  FrameHeader out;
  out.exposure_s = bounded(header, "EXPTIME", Least::kZero);
  if (!out.exposure_s) out.exposure_s = bounded(header, "EXPOSURE", Least::kZero);
  out.gain_e_per_dn = bounded(header, "EGAIN", Least::kAboveZero);
  out.saturation_dn = bounded(header, "SATURATE", Least::kAboveZero);
  out.stage_deg = header.number("STAGEDEG");
  out.arm_deg = header.number("ARMDEG");
  out.tilt_deg = header.number("TILTDEG");
  out.target = text_if_any(header, "TARGET");
  out.image_type = text_if_any(header, "IMAGETYP");
  out.row_order = row_order(header);
  out.date = header.text("DATE-OBS");
  return out;
}

FrameHeader fits_frame_header(const FitsHeader& extension, const FitsHeader& primary) {
  FrameHeader out = fits_frame_header(extension);
  if (!extension.logical("INHERIT").value_or(true)) return out;
  const FrameHeader above = fits_frame_header(primary);
  if (!out.exposure_s) out.exposure_s = above.exposure_s;
  if (!out.gain_e_per_dn) out.gain_e_per_dn = above.gain_e_per_dn;
  if (!out.saturation_dn) out.saturation_dn = above.saturation_dn;
  if (!out.stage_deg) out.stage_deg = above.stage_deg;
  if (!out.arm_deg) out.arm_deg = above.arm_deg;
  if (!out.tilt_deg) out.tilt_deg = above.tilt_deg;
  if (!out.target) out.target = above.target;
  if (!out.image_type) out.image_type = above.image_type;
  if (!out.row_order) out.row_order = above.row_order;
  if (!out.date) out.date = above.date;
  return out;
}

}  // namespace scatmap
