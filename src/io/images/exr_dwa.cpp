/* The only file that includes OpenEXR's C++ library, for DWA compression, which the C core does not decode. No
 * exception leaves it. */
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

#include <cstring>
#include <new>
#include <stdexcept>

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

} // namespace

ty_result ty_exr_read_dwa(ty_context* context, const char* path, const ty_exr_stream* stream,
                          const ty_exr_dwa_part* part, ty_image* image) {
    try {
        read_pixels(path, stream, part, image);
        return TY_OK;
    } catch (const std::bad_alloc&) {
        return ty_fail(context, TY_ERROR_MEMORY, "%s: not enough memory for OpenEXR", path);
    } catch (const std::exception& error) {
        return ty_fail(context, TY_ERROR_INPUT, "%s: %s", path, error.what());
    } catch (...) {
        return ty_fail(context, TY_ERROR_INTERNAL, "%s: OpenEXR failed", path);
    }
}
