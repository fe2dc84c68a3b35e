#!/usr/bin/python3
"""Times pyFAI, numpy, OpenCV, mrcal and ccdproc beside scatmap: the same pose, the same frames, one thread, one run.

Every rival does what its manual says; what it gives less of is said in its row. Errors of angles are distances on the
sphere against numpy's long double; none is claimed for those that compute something else.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np  # noqa: E402

R_M, PITCH_M, STAGE_DEG, ARM_DEG = 0.325, 5.5e-6, 20.0, 40.0
FULL_COLUMNS, FULL_ROWS = 3296, 2472


def best_ns(items, work, seconds=2.0, least=5):
    """Time per item, ns: first call, minimum and 90th percentile of the others."""
    times, begin = [], time.perf_counter()
    while len(times) < least + 1 or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        work()
        times.append((time.perf_counter() - start) * 1e9 / items)
    first, others = times[0], sorted(times[1:])
    return first, others[0], others[int(0.9 * (len(others) - 1))]


def pitches(columns, rows):
    """The paper's sensor with other pixels."""
    return PITCH_M * FULL_COLUMNS / columns, PITCH_M * FULL_ROWS / rows


def bench(columns, rows, real=np.float64):
    """Origin and steps of the pixels in sample axes: the detector turned by arm - stage about y."""
    turn = np.deg2rad(real(ARM_DEG) - real(STAGE_DEG))
    pc, pr = (real(p) for p in pitches(columns, rows))
    x_axis = np.array([np.cos(turn), real(0), -np.sin(turn)])
    z_axis = np.array([np.sin(turn), real(0), np.cos(turn)])
    y_axis = np.array([real(0), real(1), real(0)])
    c = (np.arange(columns, dtype=real) - real(columns - 1) / 2) * pc
    r = (np.arange(rows, dtype=real) - real(rows - 1) / 2) * pr
    return c, r, x_axis, y_axis, z_axis


def numpy_angles(columns, rows, real=np.float64):
    c, r, x_axis, y_axis, z_axis = bench(columns, rows, real)
    c, r = c[None, :], r[:, None]
    x = c * x_axis[0] + (r * y_axis[0] + R_M * z_axis[0])
    y = c * x_axis[1] + (r * y_axis[1] + R_M * z_axis[1])
    z = c * x_axis[2] + (r * y_axis[2] + R_M * z_axis[2])
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x) + real(np.pi)


def pyfai_geometry(columns, rows):
    """pyFAI's axis 1 (slow) is our x, its axis 2 our y: its arrays are ours transposed. Its rotations are left-handed."""
    from pyFAI.detectors import Detector
    from pyFAI.geometry import Geometry
    pc, pr = pitches(columns, rows)
    detector = Detector(pixel1=pc, pixel2=pr, max_shape=(columns, rows))
    return Geometry(dist=R_M, poni1=columns / 2 * pc, poni2=rows / 2 * pr, rot1=0, rot2=-np.deg2rad(ARM_DEG - STAGE_DEG),
                    rot3=0, detector=detector)


def pyfai_angles(geometry, shape):
    geometry.reset()
    return geometry.twoThetaArray(shape), geometry.chiArray(shape)


def sphere_error(theta, phi, reference):
    theta_ref, phi_ref = reference
    turn = phi.astype(np.longdouble) - phi_ref
    turn -= 2 * np.longdouble(np.pi) * np.round(turn / (2 * np.longdouble(np.pi)))
    return float(np.max(np.hypot(theta.astype(np.longdouble) - theta_ref, np.sin(theta_ref) * turn)))


def pyfai_phi(chi):
    """chi = atan2(axis 1, axis 2); phi is from -x."""
    return np.longdouble(1.5) * np.longdouble(np.pi) - chi.astype(np.longdouble)


def angle_rows(columns, rows):
    count, shape = columns * rows, (columns, rows)
    reference = numpy_angles(columns, rows, np.longdouble)
    geometry = pyfai_geometry(columns, rows)
    out = []
    theta, chi = pyfai_angles(geometry, shape)
    out.append(("pyFAI twoThetaArray + chiArray", best_ns(count, lambda: pyfai_angles(geometry, shape)),
                sphere_error(theta.T, pyfai_phi(chi.T), reference), ""))
    theta, phi = numpy_angles(columns, rows)
    out.append(("numpy broadcast, arctan2", best_ns(count, lambda: numpy_angles(columns, rows)),
                sphere_error(theta, phi, reference), ""))
    return out


def lens_rows(columns, rows):
    import cv2
    cv2.setNumThreads(1)
    f = R_M / PITCH_M
    pixels = np.stack(np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float)), -1).reshape(-1, 2)
    camera = np.array([[f, 0, (columns - 1) / 2], [0, f, (rows - 1) / 2], [0, 0, 1]])
    k = np.array([-15.0, 3.0, 1e-4, -2e-4, 0.5, 0.1, -0.2, 0.05])
    out = [("OpenCV undistortPoints, 5 iterations", best_ns(len(pixels), lambda: cv2.undistortPoints(pixels, camera, k)),
            None, "rays only")]
    try:
        import mrcal
        intrinsics = np.concatenate((np.array([f, f, (columns - 1) / 2, (rows - 1) / 2]), k))
        part = pixels[:: max(1, len(pixels) // 100000)].copy()
        out.append(("mrcal unproject, OPENCV8",
                    best_ns(len(part), lambda: mrcal.unproject(part, "LENSMODEL_OPENCV8", intrinsics)), None,
                    "rays only"))
    except ImportError:
        print("mrcal's Python package is not installed: its row is missing", file=sys.stderr)
    return out


def frame_rows(columns, rows):
    import astropy.units as u
    import ccdproc
    from astropy.nddata import CCDData
    rng = np.random.default_rng(1)
    raw = rng.poisson(2000, (rows, columns)).astype(np.uint16)
    dark = CCDData(np.full((rows, columns), 300.0), unit=u.adu)
    flat = CCDData(np.ones((rows, columns)), unit=u.electron)

    def reduce():
        ccd = CCDData(raw.astype(float), unit=u.adu)
        ccd = ccdproc.subtract_dark(ccd, dark, dark_exposure=1 * u.s, data_exposure=1 * u.s)
        ccd = ccdproc.create_deviation(ccd, gain=1.5 * u.electron / u.adu, readnoise=8 * u.electron,
                                       disregard_nan=True)
        ccd = ccdproc.gain_correct(ccd, 1.5 * u.electron / u.adu)
        return ccdproc.flat_correct(ccd, flat)

    return [("ccdproc dark, deviation, gain, flat", best_ns(columns * rows, reduce), None,
             "no angles, no solid angle, no BRDF")]


def own_rows(scatmap, job, size, seconds):
    with tempfile.TemporaryDirectory() as folder:
        text = subprocess.run([scatmap, "chart", job, "-o", os.path.join(folder, "chart"), "--json", "--seconds",
                               str(seconds)], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    out = []
    for chart in json.loads(text)["charts"]:
        for row in chart["rows"]:
            if row["size"] == size and row["threads"] == 1:
                least = row["ns_min"]
                out.append((("others' way, in C++: " if row["rival"] else "scatmap ") + row["method"],
                            (row["ns_first"], least, least + row["ns_spread"]), row["largest_error_rad"], ""))
    return out


def io_alone(inputs, output, folder):
    """Seconds to read the inputs and to write and flush the output's bytes, one thread, buffers used again."""
    with open(output, "rb") as file:
        data = memoryview(file.read())
    block, buffer = 1 << 20, bytearray(1 << 20)
    target = os.path.join(folder, "io-alone")
    start = time.perf_counter()
    for path in inputs:
        with open(path, "rb", buffering=0) as file:
            while file.readinto(buffer):
                pass
    with open(target, "wb", buffering=0) as file:
        for at in range(0, len(data), block):
            file.write(data[at:at + block])
        os.fsync(file.fileno())
    elapsed = time.perf_counter() - start
    os.unlink(target)
    return elapsed


def file_to_file(scatmap, scene, runs=7):
    """The whole process, all threads: raw frames of the paper's scene to a FITS map on the disk."""
    with tempfile.TemporaryDirectory() as folder:
        lab, output = os.path.join(folder, "lab"), os.path.join(folder, "map.fits")
        quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.run([scatmap, "simulate", scene, "-o", lab], **quiet)
        frames = os.path.join(lab, "frames")
        inputs = [os.path.join(frames, name) for name in sorted(os.listdir(frames))]
        whole, alone = [], []
        for _ in range(runs):
            start = time.perf_counter()
            subprocess.run([scatmap, "brdf", os.path.join(lab, "measurement.toml"), "-o", output], **quiet)
            whole.append(time.perf_counter() - start)
            alone.append(io_alone(inputs, output, folder))
            size = os.path.getsize(output)
            os.unlink(output)
        read = sum(os.path.getsize(path) for path in inputs)
    yield "**raw frames to a map, file to file, 3296 x 2472**\n"
    yield f"{len(inputs)} frames, {read / 1e6:.0f} MB, to a FITS map of {size / 1e6:.0f} MB, flushed to the disk.\n"
    yield "| | s, minimum | median |"
    yield "|---|---|---|"
    for name, times in (("`scatmap brdf`", whole), ("reading and writing alone, one thread", alone)):
        yield f"| {name} | {min(times):.2f} | {sorted(times)[len(times) // 2]:.2f} |"
    yield ""


def table(title, rows):
    yield f"**{title}**\n"
    yield "| | ns per pixel, first call | minimum | to 90 % | largest error, rad | |"
    yield "|---|---|---|---|---|---|"
    for name, (first, least, most), error, note in rows:
        error_text = "" if error is None else f"{error:.2g}"
        yield f"| {name} | {first:.3g} | {least:.3g} | {most:.3g} | {error_text} | {note} |"
    yield ""


def processor():
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        return next((line.split(":", 1)[1].strip() for line in info if line.startswith("model name")), "?")


def report(scatmap, scene, seconds):
    import astropy
    import ccdproc
    import cv2
    import pyFAI
    yield (f"{processor()}, one thread. pyFAI {pyFAI.version}, numpy {np.__version__}, OpenCV {cv2.__version__}, "
           f"ccdproc {ccdproc.__version__}, astropy {astropy.__version__}.\n")
    for columns, rows in ((1024, 1024), (FULL_COLUMNS, FULL_ROWS)):
        size = f"{columns} x {rows}"
        for job, title, rivals in (("angles", "both scatter angles", angle_rows), ("lens", "behind a lens", lens_rows),
                                   ("brdf", "raw frame to BRDF", frame_rows)):
            if job == "lens" and columns != 1024:
                continue  # charted at one size
            yield from table(f"{title}, {size}", rivals(columns, rows) + own_rows(scatmap, job, size, seconds))
    yield from file_to_file(scatmap, scene)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scatmap", default=".build/release/tools/scatmap")
    parser.add_argument("--scene", default="data-synthetic/scenes/full-20-0.toml", help="for file to file")
    parser.add_argument("--seconds", type=float, default=0.5, help="for each of scatmap's methods")
    parser.add_argument("-o", "--output", help="file for the tables; default standard output")
    arguments = parser.parse_args()
    text = "\n".join(report(arguments.scatmap, arguments.scene, arguments.seconds)) + "\n"
    if arguments.output:
        with open(arguments.output, "w", encoding="utf-8") as out:
            out.write(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
