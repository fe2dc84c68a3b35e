#include "scatmap/report/map_exr.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "scatmap/base/error.h"
#include "scatmap/base/units.h"

namespace scatmap {
namespace {

struct Channel {
  std::string name;
  Grid<float> data;
};

template <class T>
Channel channel(const std::string& name, const Grid<T>& data, double factor = 1) {
  Channel out{name, Grid<float>(data.rows(), data.columns())};
  for (std::size_t i = 0; i < data.size(); ++i) out.data[i] = static_cast<float>(static_cast<double>(data[i]) * factor);
  return out;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

void write_channels(Imf::Header& header, const std::vector<Channel>& channels, const std::filesystem::path& target,
                    Overwrite overwrite) {
  OutputFile out(target, overwrite);
  try {
    Imf::FrameBuffer buffer;
    for (const Channel& c : channels) {
      header.channels().insert(c.name, Imf::Channel(Imf::FLOAT));
      const std::size_t stride = static_cast<std::size_t>(c.data.columns()) * sizeof(float);
      buffer.insert(c.name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(c.data.data())),
                                       sizeof(float), stride));
    }
    Imf::OutputFile file(out.temporary().c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(channels.front().data.rows());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error({target.string(), std::string("cannot be written: ") + e.what(), {}, {}});
  }
  out.commit();
}

void insert_text(Imf::Header& header, const char* name, const std::string& text) {
  header.insert(name, Imf::StringAttribute(text));
}
void insert_number(Imf::Header& header, const char* name, double value) {
  header.insert(name, Imf::DoubleAttribute(value));
}

Imf::Header header_for(int rows, int columns, const AngleMap& angles, const Provenance& provenance) {
  Imf::Header header(columns, rows);
  header.compression() = Imf::ZIP_COMPRESSION;
  insert_number(header, "theta_i_deg", angles.theta_i_rad * kDegPerRad);
  insert_number(header, "phi_i_deg", 0);
  insert_text(header, "angle_convention",
              "sample axes: z normal, x in-plane forward; phi from -x towards -y, specular at 180 deg");
  insert_text(header, "creator", provenance.written_by);
  insert_text(header, "command_line", provenance.command_line);
  std::string inputs;
  for (const InputRecord& r : provenance.inputs) inputs += r.path + " sha256 " + r.sha256 + "\n";
  insert_text(header, "inputs", inputs);
  return header;
}

void add_angles(std::vector<Channel>& channels, const AngleMap& angles) {
  channels.push_back(channel("theta_s_deg", angles.theta_s_rad, kDegPerRad));
  channels.push_back(channel("phi_s_deg", angles.phi_s_rad, kDegPerRad));
  channels.push_back(channel("solid_angle_sr", angles.solid_angle_sr));
}

}  // namespace

void write_map_exr(const BrdfMap& map, const std::filesystem::path& target, Overwrite overwrite) {
  std::vector<Channel> channels{channel("Y", map.brdf_per_sr), channel("mask", map.mask)};
  if (!map.u_random_per_sr.empty()) {
    channels.push_back(channel("uncert", per_pixel_uncertainty(map)));
    channels.push_back(channel("u_random", map.u_random_per_sr));
  }
  if (!map.u_pose_per_sr.empty()) channels.push_back(channel("u_pose", map.u_pose_per_sr));
  for (const StructuredCause& s : map.structured) channels.push_back(channel(lower(s.name), s.sensitivity_per_sr));
  add_angles(channels, map.angles);
  Imf::Header header = header_for(map.brdf_per_sr.rows(), map.brdf_per_sr.columns(), map.angles, map.provenance);
  insert_text(header, "unit", "sr-1");
  insert_number(header, "wavelength_nm", map.wavelength_m / kMetrePerNm);
  insert_number(header, "stage_deg", map.pose.stage_rad * kDegPerRad);
  insert_number(header, "arm_deg", map.pose.arm_rad * kDegPerRad);
  if (!map.u_random_per_sr.empty()) {
    const ScaleInterval interval = map.scale.filters_interval();
    insert_number(header, "u_scale_relative", map.scale.standard());
    insert_number(header, "nd_worst_case", map.scale.filters_worst_case());
    insert_number(header, "nd_standard", map.scale.filters_standard());
    insert_number(header, "nd_interval_low", interval.low);
    insert_number(header, "nd_interval_high", interval.high);
  }
  write_channels(header, channels, target, overwrite);
}

void write_angles_exr(const AngleMap& angles, const Provenance& provenance, const std::filesystem::path& target,
                      Overwrite overwrite) {
  std::vector<Channel> channels{channel("Y", angles.theta_s_rad, kDegPerRad), channel("mask", angles.mask)};
  add_angles(channels, angles);
  Imf::Header header = header_for(angles.mask.rows(), angles.mask.columns(), angles, provenance);
  insert_text(header, "unit", "deg");
  write_channels(header, channels, target, overwrite);
}

}  // namespace scatmap
