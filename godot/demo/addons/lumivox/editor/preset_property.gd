@tool
extends EditorProperty
## The presets in the inspector of several volumes: choosing one is one undo step for all of them.
##
## The engine's own editor would only undo the preset's name, not what the preset set.

## Emitted when a preset was chosen; an empty string forgets which.
signal chosen(preset: String)

## Shown while the volumes have different ones.
const MIXED := "Several"

var _names: PackedStringArray = []
var _button := OptionButton.new()


func _init() -> void:
	_names = PackedStringArray([""]) + LumivoxVolume3D.preset_names()
	for preset in _names:
		_button.add_item(preset)
	_button.clip_text = true
	_button.flat = true
	_button.item_selected.connect(func(index: int) -> void: chosen.emit(_names[index]))
	add_child(_button)
	add_focusable(_button)


func _update_property() -> void:
	var presets: Dictionary[String, bool] = {}
	for node in EditorInterface.get_selection().get_selected_nodes():
		if node is LumivoxVolume3D:
			presets[(node as LumivoxVolume3D).preset] = true
	if presets.size() == 1:
		_button.select(_names.find(presets.keys()[0]))
	else:
		_button.select(-1)
		_button.text = MIXED
