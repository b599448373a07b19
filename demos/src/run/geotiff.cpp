#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <memory>
#include <tuple>

#include "height_map.h"

namespace bsoil::scene {
namespace {

// Tags and keys of OGC 19-008r4.
constexpr uint32_t kModelTransformation = 34264, kGeoKeyDirectory = 34735, kGeoAsciiParams = 34737;
constexpr char kCitation[] = "BulletSoil world|";

/// libtiff calls it for each file that is opened: until then it knows no tag of GeoTIFF.
void add_tags(TIFF* tiff) {
    static const TIFFFieldInfo fields[] = {
        {kModelTransformation, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1,
         const_cast<char*>("Transformation")},
        {kGeoKeyDirectory, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, const_cast<char*>("GeoKeys")},
        {kGeoAsciiParams, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("GeoAscii")}};
    TIFFMergeFieldInfo(tiff, fields, static_cast<uint32_t>(std::size(fields)));
}

void say_nothing(const char*, const char*, va_list) {}

struct Close {
    void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

void set_tags(TIFF* tiff, const HeightMap& map) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, static_cast<uint32_t>(map.width));
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, static_cast<uint32_t>(map.height));
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff, 0));
    // From column and row to east and north, as a matrix of rows.
    const auto& [corner, column, row] = std::tie(map.corner, map.column_way, map.row_way);
    const double matrix[16] = {column.east_m,
                               row.east_m,
                               0,
                               corner.east_m,  //
                               column.north_m,
                               row.north_m,
                               0,
                               corner.north_m,  //
                               0,
                               0,
                               0,
                               0,  //
                               0,
                               0,
                               0,
                               1};
    TIFFSetField(tiff, kModelTransformation, 16, matrix);
    constexpr uint16_t kUserDefined = 32767, kMetre = 9001;
    constexpr uint16_t kCitationLength = sizeof(kCitation) - 1;
    constexpr uint16_t kKeys[] = {1,
                                  1,
                                  1,
                                  4,  // version, count of keys
                                  1024,
                                  0,
                                  1,
                                  kUserDefined,  // model: the world's own
                                  1025,
                                  0,
                                  1,
                                  1,  // a pixel is an area
                                  1026,
                                  kGeoAsciiParams,
                                  kCitationLength,
                                  0,
                                  3076,
                                  0,
                                  1,
                                  kMetre};
    TIFFSetField(tiff, kGeoKeyDirectory, static_cast<int>(std::size(kKeys)), kKeys);
    TIFFSetField(tiff, kGeoAsciiParams, kCitation);
}

}  // namespace

Status write_geotiff(const HeightMap& map, const std::string& path) {
    TIFFSetTagExtender(add_tags);
    TIFFSetErrorHandler(say_nothing);  // what goes wrong is told by the result
    const std::unique_ptr<TIFF, Close> tiff(TIFFOpen(path.c_str(), "w"));
    if (!tiff) return Error{path + ": cannot be written; check its folder and the disk"};
    set_tags(tiff.get(), map);
    std::vector<float> row(static_cast<size_t>(map.width));
    bool written = true;
    for (int y = 0; y < map.height; ++y) {
        const auto first = map.heights_m.begin() + static_cast<std::ptrdiff_t>(y) * map.width;
        std::transform(first, first + map.width, row.begin(),
                       [](double height) { return static_cast<float>(height); });
        written &= TIFFWriteScanline(tiff.get(), row.data(), static_cast<uint32_t>(y), 0) == 1;
    }
    written &= TIFFFlush(tiff.get()) == 1;
    if (!written) return Error{path + ": cannot be written whole; look whether the disk is full"};
    return Done{};
}

}  // namespace bsoil::scene
