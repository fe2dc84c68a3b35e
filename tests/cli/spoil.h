#pragma once
#include <fitsio.h>

#include "cli/lab.h"
#include "frame/fits_sums.h"

/// Ways to spoil a laboratory's good files.
namespace scatmap::test {

using Spoil = std::function<void(Lab&)>;

inline Spoil nothing() {
  return [](Lab&) {};
}
inline Spoil replace(std::string file, std::string from, std::string to) {
  return [=](Lab& lab) { lab.replace(file, from, to); };
}
inline Spoil write(std::string file, std::string bytes) {
  return [=](Lab& lab) { lab.write(file, bytes); };
}
inline Spoil append(std::string file, std::string text) {
  return [=](Lab& lab) { lab.write(file, lab.read(file) + text); };
}
inline Spoil cut(std::string file, std::size_t bytes) {
  return [=](Lab& lab) { fs::resize_file(lab.path(file), bytes); };
}
inline Spoil erase(std::string file) {
  return [=](Lab& lab) { fs::remove_all(lab.path(file)); };
}
inline Spoil make_folder(std::string name) {
  return [=](Lab& lab) { fs::create_directory(lab.path(name)); };
}
inline Spoil unreadable(std::string file) {
  return [=](Lab& lab) { fs::permissions(lab.path(file), fs::perms::none); };
}
inline Spoil read_only(std::string file) {
  return [=](Lab& lab) { fs::permissions(lab.path(file), fs::perms::owner_read | fs::perms::owner_exec); };
}
inline Spoil copy(std::string from, std::string to) {
  return [=](Lab& lab) { fs::copy_file(lab.path(from), lab.path(to), fs::copy_options::overwrite_existing); };
}
inline Spoil all(std::vector<Spoil> steps) {
  return [=](Lab& lab) {
    for (const Spoil& step : steps) step(lab);
  };
}

inline Spoil without_sums(std::string file) {
  return [=](Lab& lab) { lab.write(file, without_fits_sums(lab.read(file))); };
}

/// The value of a FITS card, in place; for a `key` that is absent, the DATE-OBS card becomes one.
inline Spoil card(std::string file, std::string key, std::string value) {
  return [=](Lab& lab) {
    without_sums(file)(lab);
    std::string bytes = lab.read(file), name = key;
    name.resize(8, ' ');
    std::size_t at = 0;
    while (at < 2880 && bytes.compare(at, 8, name) != 0) at += 80;
    for (std::size_t i = 0; at == 2880 && i < 2880; i += 80) at = bytes.compare(i, 8, "DATE-OBS") == 0 ? i : at;
    if (at == 2880) throw std::runtime_error(file + " has no card to change");
    std::string text = name + "= " + value;
    text.resize(80, ' ');
    lab.write(file, bytes.replace(at, 80, text));
  };
}

/// 16-bit frames of `simulate`: one header block, 64 × 64 pixels, BZERO 32768.
inline constexpr std::size_t kHeaderBytes = 2880, kSide = 64;

/// Sets every pixel for which `chosen(column, row)`.
inline Spoil pixels(std::string file, std::uint16_t dn, std::function<bool(std::size_t, std::size_t)> chosen) {
  return [=](Lab& lab) {
    std::string bytes = lab.read(file);
    const auto stored = static_cast<std::uint16_t>(dn ^ 0x8000U);
    for (std::size_t i = 0; i < kSide * kSide; ++i) {
      if (!chosen(i % kSide, i / kSide)) continue;
      bytes.at(kHeaderBytes + 2 * i) = static_cast<char>(stored >> 8U);
      bytes.at(kHeaderBytes + 2 * i + 1) = static_cast<char>(stored & 0xffU);
    }
    lab.write(file, bytes);
  };
}

/// Moves the picture to the right, what leaves comes back on the left.
inline Spoil roll_columns(std::string file, std::size_t columns) {
  return [=](Lab& lab) {
    std::string bytes = lab.read(file);
    for (std::size_t row = 0; row < kSide; ++row) {
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(kHeaderBytes + 2 * kSide * row);
      std::rotate(begin, begin + static_cast<std::ptrdiff_t>(2 * (kSide - columns)), begin + 2 * kSide);
    }
    lab.write(file, bytes);
  };
}

/// As fpack would: the image in a compressed table of an extension.
inline Spoil tile_compress(std::string file) {
  return [=](Lab& lab) {
    int status = 0;
    fitsfile *in = nullptr, *out = nullptr;
    const std::string plain = lab.path(file).string(), packed = plain + ".packed";
    fits_open_diskfile(&in, plain.c_str(), READONLY, &status);
    fits_create_diskfile(&out, packed.c_str(), &status);
    fits_set_compression_type(out, RICE_1, &status);
    fits_img_compress(in, out, &status);
    fits_close_file(out, &status);
    fits_close_file(in, &status);
    if (status != 0) throw std::runtime_error("cannot compress " + file);
    fs::rename(packed, plain);
  };
}

/// The same number of bytes elsewhere in a binary file.
inline Spoil overwrite_bytes(std::string file, std::string from, std::string to) {
  if (from.size() != to.size()) throw std::runtime_error("lengths differ: " + from);
  return all({without_sums(file), replace(file, std::move(from), std::move(to))});
}

}  // namespace scatmap::test
