class_name EyePictures
extends CompositorEffect
## Keeps what each eye of a viewport was shown in the last frame, in linear light, before the engine's tone mapper.
##
## The textures that a headset lends cannot be read by scripts, so the picture is copied on its way there.

const SHADER := "#version 450
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D seen;
layout(rgba32f, set = 0, binding = 1) uniform restrict writeonly image2D kept;
void main() {
	ivec2 at = ivec2(gl_GlobalInvocationID.xy);
	if (all(lessThan(at, imageSize(kept)))) {
		imageStore(kept, at, texelFetch(seen, at, 0));
	}
}
"

var _device := RenderingServer.get_rendering_device()
var _shader: RID
var _pipeline: RID
var _sampler: RID
var _kept: Array[RID] = []
var _size := Vector2i.ZERO


func _init() -> void:
	effect_callback_type = EFFECT_CALLBACK_TYPE_POST_TRANSPARENT
	var source := RDShaderSource.new()
	source.source_compute = SHADER
	_shader = _device.shader_create_from_spirv(_device.shader_compile_spirv_from_source(source))
	_pipeline = _device.compute_pipeline_create(_shader)
	_sampler = _device.sampler_create(RDSamplerState.new())


## The eyes' pictures, left to right.
func images() -> Array[Image]:
	var found: Array[Image] = []
	for texture in _kept:
		var bytes := _device.texture_get_data(texture, 0)
		found.append(Image.create_from_data(_size.x, _size.y, false, Image.FORMAT_RGBAF, bytes))
	return found


func free_all() -> void:
	for rid: RID in _kept + [_pipeline, _shader, _sampler]:
		_device.free_rid(rid)
	_kept.clear()


func _render_callback(_type: int, data: RenderData) -> void:
	var buffers := data.get_render_scene_buffers() as RenderSceneBuffersRD
	if buffers.get_internal_size() != _size or _kept.size() != buffers.get_view_count():
		for texture in _kept:
			_device.free_rid(texture)
		_size = buffers.get_internal_size()
		_kept.clear()
		for view in buffers.get_view_count():
			_kept.append(_texture())
	for view in buffers.get_view_count():
		_copy(buffers.get_color_layer(view), _kept[view])


func _texture() -> RID:
	var format := RDTextureFormat.new()
	format.width = _size.x
	format.height = _size.y
	format.format = RenderingDevice.DATA_FORMAT_R32G32B32A32_SFLOAT
	format.usage_bits = RenderingDevice.TEXTURE_USAGE_STORAGE_BIT | RenderingDevice.TEXTURE_USAGE_CAN_COPY_FROM_BIT
	return _device.texture_create(format, RDTextureView.new())


func _copy(from: RID, to: RID) -> void:
	var seen := RDUniform.new()
	seen.uniform_type = RenderingDevice.UNIFORM_TYPE_SAMPLER_WITH_TEXTURE
	seen.binding = 0
	seen.add_id(_sampler)
	seen.add_id(from)
	var kept := RDUniform.new()
	kept.uniform_type = RenderingDevice.UNIFORM_TYPE_IMAGE
	kept.binding = 1
	kept.add_id(to)
	var bound := UniformSetCacheRD.get_cache(_shader, 0, [seen, kept])
	var list := _device.compute_list_begin()
	_device.compute_list_bind_compute_pipeline(list, _pipeline)
	_device.compute_list_bind_uniform_set(list, bound, 0)
	_device.compute_list_dispatch(list, ceili(_size.x / 8.0), ceili(_size.y / 8.0), 1)
	_device.compute_list_end()
