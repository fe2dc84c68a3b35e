#pragma once
#include <stddef.h>

/// The C interface of the optional module libscatmap_mrcal.so, the only part of scatmap that links mrcal. It is a
/// module of its own because loading Debian's mrcal 2.2 makes the stack of the process executable; lens.cpp opens it
/// when a lens model is used, and never otherwise.
extern "C" {

struct scatmap_lens;

/// @param text a .cameramodel as to_cameramodel(LensFile) writes it, never a file's own text: mrcal's reader trusts it.
/// @return a camera model, to be freed by scatmap_lens_free; null if mrcal cannot read it (it says why on stderr)
scatmap_lens* scatmap_lens_parse(const char* text);
void scatmap_lens_free(scatmap_lens* lens);
int scatmap_lens_columns(const scatmap_lens* lens);
int scatmap_lens_rows(const scatmap_lens* lens);
/// "LENSMODEL_OPENCV8" and the like.
const char* scatmap_lens_name(const scatmap_lens* lens);
/// Copies the model's intrinsics (focal lengths, centre, then the coefficients) if they are at most `room` numbers.
/// @return how many there are
size_t scatmap_lens_intrinsics(const scatmap_lens* lens, double* intrinsics, size_t room);
/// Rays of `count` pixel positions (column, row each; integers are pixel centres): 3 numbers each, of any length,
/// camera axes; NaN where the model has no answer. @return 0 if the model cannot be unprojected at all
int scatmap_lens_unproject(const scatmap_lens* lens, const double* positions, size_t count, double* rays);

}  // extern "C"
