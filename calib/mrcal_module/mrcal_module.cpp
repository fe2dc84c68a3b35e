// The only file of scatmap that includes mrcal (2.2: no C++ guards in its headers).
extern "C" {
#include <mrcal/mrcal.h>
}

#include <array>
#include <vector>

#include "scatmap/angles/lens_module.h"

struct scatmap_lens {
  mrcal_cameramodel_t* model;
  std::array<char, 256> name;
};

scatmap_lens* scatmap_lens_parse(const char* text) {
  mrcal_cameramodel_t* model = mrcal_read_cameramodel_string(text, 0);
  if (model == nullptr) return nullptr;
  auto* lens = new scatmap_lens{model, {}};
  if (!mrcal_lensmodel_name(lens->name.data(), static_cast<int>(lens->name.size()), &model->lensmodel))
    lens->name = {"unknown"};
  return lens;
}

void scatmap_lens_free(scatmap_lens* lens) {
  if (lens == nullptr) return;
  mrcal_free_cameramodel(&lens->model);
  delete lens;
}

int scatmap_lens_columns(const scatmap_lens* lens) { return static_cast<int>(lens->model->imagersize[0]); }
int scatmap_lens_rows(const scatmap_lens* lens) { return static_cast<int>(lens->model->imagersize[1]); }
const char* scatmap_lens_name(const scatmap_lens* lens) { return lens->name.data(); }

size_t scatmap_lens_intrinsics(const scatmap_lens* lens, double* intrinsics, size_t room) {
  const auto count = static_cast<size_t>(mrcal_lensmodel_num_params(&lens->model->lensmodel));
  for (size_t i = 0; i < count && count <= room; ++i) intrinsics[i] = lens->model->intrinsics[i];
  return count;
}

int scatmap_lens_unproject(const scatmap_lens* lens, const double* positions, size_t count, double* rays) {
  std::vector<mrcal_point2_t> pixels(count);
  std::vector<mrcal_point3_t> vectors(count);
  for (size_t i = 0; i < count; ++i) {
    pixels[i].x = positions[2 * i];
    pixels[i].y = positions[2 * i + 1];
  }
  // A point without solution gets NaN in x and y only.
  if (!mrcal_unproject(vectors.data(), pixels.data(), static_cast<int>(count), &lens->model->lensmodel,
                       lens->model->intrinsics))
    return 0;
  for (size_t i = 0; i < count; ++i) {
    rays[3 * i] = vectors[i].x;
    rays[3 * i + 1] = vectors[i].y;
    rays[3 * i + 2] = vectors[i].z;
  }
  return 1;
}
