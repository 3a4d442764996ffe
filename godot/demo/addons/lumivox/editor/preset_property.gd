@tool
extends EditorProperty
## The presets in the inspector, of one volume or of several: the gallery of the transfer-function editor.

## Emitted when a preset was chosen for several volumes, which is one undo step for all of them. The engine's own editor of
## several nodes would only undo the preset's name, not what the preset set.
signal chosen_for_all(preset: String)

const PresetGallery := preload("../ui/preset_gallery.gd")
## Shown while the volumes have different ones.
const MIXED := "Several"
## Shown without one.
const NONE := "None"

var _button := Button.new()
var _gallery := PresetGallery.new()
var _volumes: Array[LumivoxVolume3D] = []


func _init(volumes: Array[LumivoxVolume3D] = []) -> void:
	_volumes = volumes
	_button.clip_text = true
	_button.flat = true
	_button.alignment = HORIZONTAL_ALIGNMENT_LEFT
	# A popup that opens while its button is still pressed closes again.
	_button.pressed.connect(_open, CONNECT_DEFERRED)
	_button.add_child(_gallery)
	_gallery.chosen.connect(_on_chosen)
	add_child(_button)
	add_focusable(_button)


func _update_property() -> void:
	var presets: Dictionary[String, bool] = {}
	for node in _volumes:
		if is_instance_valid(node):
			presets[node.preset] = true
	var preset: String = presets.keys()[0] if presets.size() == 1 else ""
	_button.text = MIXED if presets.size() > 1 else NONE if preset == "" else PresetGallery.title(preset)
	_button.tooltip_text = preset


func _open() -> void:
	var shown := _volumes.filter(func(node: LumivoxVolume3D) -> bool: return is_instance_valid(node))
	if shown.is_empty():
		return
	_gallery.set_volume((shown[0] as LumivoxVolume3D).volume)
	_gallery.open_at(Rect2(_button.get_screen_position(), _button.size))


func _on_chosen(preset: String) -> void:
	if _volumes.size() == 1:
		emit_changed(get_edited_property(), preset)
	else:
		chosen_for_all.emit(preset)
