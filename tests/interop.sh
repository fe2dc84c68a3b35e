#!/usr/bin/env bash
# Opens scatmap's outputs with other people's programs: astropy (CCDData, wcslib), OpenCV, exrheader and, where it is
# installed, fitsverify. Not part of ctest: it installs Debian's python3-astropy, python3-opencv and openexr.
#   bash tests/interop.sh      after bash tests/run.sh
set -eu
cd "$(dirname "$0")/.."
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)
"${as_root[@]}" apt-get install -y -qq --no-install-recommends python3-astropy python3-opencv openexr >/dev/null
scatmap=$PWD/.build/release/tools/scatmap
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$scatmap" simulate data-synthetic/scenes/every-parameter.toml -o "$folder/data" >/dev/null
"$scatmap" brdf "$folder/data/measurement.toml" -o "$folder/map.fits" -o "$folder/map.exr" --precision double >/dev/null
exrheader "$folder/map.exr" | grep -E 'theta_i_deg|Y, 32-bit' 
if command -v fitsverify >/dev/null; then fitsverify -q "$folder/map.fits"; fi
/usr/bin/python3 - "$folder" <<'PY'
import os, sys
os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
import cv2, numpy as np
from astropy.io import fits
from astropy.nddata import CCDData, StdDevUncertainty

folder = sys.argv[1]
data = CCDData.read(folder + "/map.fits")
assert str(data.unit) == "1 / sr" and isinstance(data.uncertainty, StdDevUncertainty) and data.mask.dtype == bool, data
hdus = fits.open(folder + "/map.fits", checksum=True)
rows, columns = np.mgrid[0 : data.data.shape[0], 0 : data.data.shape[1]]
longitude, latitude = data.wcs.wcs_pix2world(columns, rows, 0)
theta = np.radians(90 - latitude - hdus["THETA_S_DEG"].data)
phi = np.radians((longitude - hdus["PHI_S_DEG"].data + 180) % 360 - 180)
print("WCS against the angle images, rad: theta %.1e, phi %.1e" % (np.nanmax(abs(theta)), np.nanmax(abs(phi))))
assert np.nanmax(abs(theta)) <= 1e-12 and np.nanmax(abs(phi)) <= 1e-12
image = cv2.imread(folder + "/map.exr", cv2.IMREAD_UNCHANGED)
assert image is not None and image.dtype == np.float32
good = ~data.mask
grey = image if image.ndim == 2 else image[..., 0]
assert np.array_equal(grey[good], data.data[good].astype(np.float32))
print("CCDData, WCS and OpenCV's EXR reader: ok, %d good pixels" % good.sum())
PY
