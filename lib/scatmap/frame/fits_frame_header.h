#pragma once
#include "scatmap/frame/fits_header.h"
#include "scatmap/frame/frame.h"

namespace scatmap {

/// What a FITS header says of the exposure, by the keywords named in frame.h.
/// @throws Error naming file and key if a key is there but is not a number (EXPTIME: >= 0 s; EGAIN, SATURATE: > 0),
/// or is no known ROWORDER
FrameHeader fits_frame_header(const FitsHeader& header);

/// The same for an image in an extension: what its own header leaves open is taken from the primary header, which then
/// describes nothing else (the INHERIT convention; INHERIT = F forbids it).
FrameHeader fits_frame_header(const FitsHeader& extension, const FitsHeader& primary);

}  // namespace scatmap
