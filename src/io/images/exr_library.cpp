/* The only file that includes OpenEXR's C++ library: DWA compression, which the C core does not decode, and luminance
 * with subsampled chroma. No exception leaves it. */
#include "io/images/exr.h"

extern "C" {
#include "base/context.h"
}

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfRgbaFile.h>

#include <cstring>
#include <new>
#include <stdexcept>
#include <vector>

namespace {

class memory_stream : public Imf::IStream {
  public:
    memory_stream(const char* path, const ty_exr_stream* source) : Imf::IStream(path), stream(source), at(0) {
    }

    bool read(char to[], int count) override {
        if (count < 0 || at > stream->size || static_cast<uint64_t>(count) > stream->size - at)
            throw std::runtime_error("the file is cut short");
        std::memcpy(to, stream->bytes + at, static_cast<size_t>(count));
        at += static_cast<uint64_t>(count);
        return at < stream->size;
    }

    uint64_t tellg() override {
        return at;
    }

    void seekg(uint64_t position) override {
        at = position;
    }

  private:
    const ty_exr_stream* stream;
    uint64_t at;
};

/* The data window must equal the one that the core library found, which sized the image. */
void check_window(const Imath::Box2i& found, const exr_attr_box2i_t& expected) {
    if (found.min.x != expected.min.x || found.min.y != expected.min.y || found.max.x != expected.max.x ||
        found.max.y != expected.max.y)
        throw std::runtime_error("the data window is given twice");
}

void read_pixels(const char* path, const ty_exr_stream* stream, const ty_exr_dwa_part* part, ty_image* image) {
    memory_stream memory(path, stream);
    Imf::MultiPartInputFile file(memory, 0, false);
    Imf::InputPart input(file, part->index);
    const Imath::Box2i window = input.header().dataWindow();
    check_window(window, part->data);
    const size_t stride = static_cast<size_t>(image->width);
    const size_t corner =
        static_cast<size_t>(part->data.min.y - part->y0) * stride + static_cast<size_t>(part->data.min.x - part->x0);
    Imf::FrameBuffer target;
    for (int i = 0; i < part->channels->num_channels; ++i)
        target.insert(part->channels->entries[i].name.str,
                      Imf::Slice::Make(Imf::FLOAT, ty_image_plane(image, part->first_channel + i) + corner, window,
                                       sizeof(float), sizeof(float) * stride));
    input.setFrameBuffer(target);
    input.readPixels(window.min.y, window.max.y);
}

void read_chroma(const char* path, const ty_exr_stream* stream, const exr_attr_box2i_t* data, bool alpha,
                 ty_image* image) {
    memory_stream memory(path, stream);
    Imf::RgbaInputFile file(memory, 0);
    const Imath::Box2i window = file.dataWindow();
    check_window(window, *data);
    const size_t width = static_cast<size_t>(image->width), height = static_cast<size_t>(image->height);
    std::vector<Imf::Rgba> pixels(width * height);
    /* The library counts from the pixel (0, 0) of the file. */
    Imf::Rgba* origin = pixels.data() - window.min.x - static_cast<int64_t>(window.min.y) * image->width;
    file.setFrameBuffer(origin, 1, width);
    file.readPixels(window.min.y, window.max.y);
    float* planes[4];
    for (int c = 0; c < 3 + alpha; ++c) planes[c] = ty_image_plane(image, c);
    for (size_t i = 0; i < pixels.size(); ++i) {
        const Imf::Rgba& pixel = pixels[i];
        if (alpha) planes[0][i] = pixel.a;
        planes[alpha][i] = pixel.b;
        planes[alpha + 1][i] = pixel.g;
        planes[alpha + 2][i] = pixel.r;
    }
}

/* Calls a reader and turns its exceptions into errors. */
template <typename reader>
ty_result guard(ty_context* context, const char* path, const reader& read) {
    try {
        read();
        return TY_OK;
    } catch (const std::bad_alloc&) {
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory for OpenEXR", path);
    } catch (const std::exception& error) {
        return ty_fail(context, TY_ERROR_INPUT, "%s: %s", path, error.what());
    } catch (...) {
        return ty_fail(context, TY_ERROR_INTERNAL, "%s: OpenEXR failed", path);
    }
}

} // namespace

ty_result ty_exr_read_dwa(ty_context* context, const char* path, const ty_exr_stream* stream,
                          const ty_exr_dwa_part* part, ty_image* image) {
    return guard(context, path, [&] { read_pixels(path, stream, part, image); });
}

ty_result ty_exr_read_chroma(ty_context* context, const char* path, const ty_exr_stream* stream,
                             const exr_attr_box2i_t* data, bool alpha, ty_image* image) {
    return guard(context, path, [&] { read_chroma(path, stream, data, alpha, image); });
}
