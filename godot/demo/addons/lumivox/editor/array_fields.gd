@tool
extends HBoxContainer
## What arrays, stacks of pictures and OME-Zarr do not say themselves: how far apart their voxels are, where they lie and what
## their axes are. Named as in scripts and in the command.

## Emitted when a field was filled in.
signal submitted

## What each field is to hold, by the reader's options.
const PLACEHOLDERS: Dictionary[String, String] = {
	"spacing": "Spacing of x, y, z in mm: 0.5,0.5,2", "axes": "Axes in the patient: LPS", "layout": "Layout of an array: zyx",
}
## Formats, as reports name them, whose files say all of it.
const COMPLETE: PackedStringArray = ["DICOM", "NIfTI", "NRRD", "MetaImage", "MGH", "RAW"]
const ENDINGS: PackedStringArray = ["npy", "tif", "tiff", "png", "zarr"]

var _fields: Dictionary[String, LineEdit] = {}


func _init() -> void:
	for option in PLACEHOLDERS:
		var field := LineEdit.new()
		field.placeholder_text = PLACEHOLDERS[option]
		field.tooltip_text = PLACEHOLDERS[option]
		field.size_flags_horizontal = Control.SIZE_EXPAND_FILL
		field.text_submitted.connect(func(_text: String) -> void: submitted.emit())
		_fields[option] = field
		add_child(field)
	hide()


## Whether a file, or what a report says that it is, may leave it open.
static func may_help(path: String, format := "") -> bool:
	if format != "":
		return format not in COMPLETE
	return path.trim_suffix("/").get_extension().to_lower() in ENDINGS


## The options of the import dock for such a file.
static func dock_options() -> Array[Dictionary]:
	var options: Array[Dictionary] = []
	for option in PLACEHOLDERS:
		options.append({
			"name": option, "default_value": "",
			"property_hint": PROPERTY_HINT_PLACEHOLDER_TEXT, "hint_string": PLACEHOLDERS[option].get_slice(": ", 1),
		})
	return options


func set_editable(is_editable: bool) -> void:
	for option in _fields:
		_fields[option].editable = is_editable


func clear() -> void:
	for option in _fields:
		_fields[option].text = ""


## What was filled in, for the reader.
func options() -> Dictionary:
	var filled := {}
	for option in _fields:
		var text := _fields[option].text.strip_edges()
		if text != "":
			filled[option] = text
	return filled
