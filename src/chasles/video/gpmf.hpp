#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

// GoPro's metadata format (GPMF) by its public description
// (https://github.com/gopro/gpmf-parser#gpmf-deeper-dive): items of a key of four letters, a type,
// the size of a sample, the number of samples and their bytes, which may be items again. Numbers
// are big-endian.

/// An item. `data` is part of the bytes that it was read from.
struct GpmfItem {
  std::string key;       ///< "ACCL"
  char type = '\0';      ///< zero: `data` are items
  std::size_t size = 0;  ///< of a sample [bytes]
  std::size_t repeat = 0;
  std::string_view data;  ///< size * repeat bytes

  bool is_nest() const { return type == '\0'; }
};

/// The items of one level. Throws InputError, starting with `where`, for an item that is longer
/// than the bytes. A key of zeros ends them, as padding does.
std::vector<GpmfItem> gpmf_items(std::string_view bytes, const std::string& where);

/// The numbers of an item in its order: one or several for each sample. Throws InputError, starting
/// with `where`, for types of other things and for sizes that do not fit the type.
std::vector<double> gpmf_numbers(const GpmfItem& item, const std::string& where);

/// The same for one whole number without a sign, as a count or a time is, which a double may not
/// hold.
std::uint64_t gpmf_count(const GpmfItem& item, const std::string& where);

/// The text of an item, without zeros and blanks at its end. Superscripts of Latin-1 (m/s²) become
/// digits.
std::string gpmf_text(const GpmfItem& item);

/// Samples of one sensor in one payload, in SI units, with what the stream states of them. Axes are
/// those of the sensor's channels.
struct GpmfSamples {
  std::string key;                                ///< "ACCL"
  std::string device;                             ///< its identifier and name: "1 GoPro Max"
  std::vector<std::vector<double>> samples = {};  ///< of one size
  std::size_t count = 0;                          ///< of all samples, also where they are not read
  std::optional<std::uint64_t> stamp = {};        ///< STMP: of the first sample [us]
  std::optional<std::uint64_t> total = {};        ///< TSMP: samples so far, with these
  double delay = 0;                               ///< TIMO [s]
  std::string unit = {};                          ///< SIUN or UNIT, as written
  std::string name = {};                          ///< STNM
  std::string axes_in = {};         ///< ORIN: axis of each channel, small: its negative: "XzY"
  std::string axes_out = {};        ///< ORIO: axis of each row of `matrix`: "ZXY"
  std::vector<double> matrix = {};  ///< MTRX, row by row: from channels to the axes of ORIO
};

/// All streams of a payload that are sampled, by device. The values of those in `wanted` are read,
/// divided by SCAL. Throws InputError, starting with `where`.
std::vector<GpmfSamples> gpmf_streams(std::string_view payload,
                                      const std::vector<std::string>& wanted,
                                      const std::string& where);

}  // namespace chasles
