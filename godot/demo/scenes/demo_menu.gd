class_name DemoMenu
extends CanvasLayer
## The demo's menu: scenes to switch between, what this one shows, and a note while the phantom grows.

const PanelTheme := preload("res://addons/lumivox/ui/panel_theme.gd")

const SCENES: Dictionary[String, String] = {
	"Head": "res://main.tscn",
	"Occlusion": "res://scenes/occlusion.tscn",
	"Many volumes": "res://scenes/many_volumes.tscn",
	"Clipping": "res://scenes/clipping.tscn",
	"Transfer function": "res://scenes/transfer_function.tscn",
	"VR": "res://scenes/vr.tscn",
}

## One or two lines on what the scene shows.
@export_multiline var caption := ""
## What is waited for; the note goes when it is there.
@export var source: PhantomSource

var _note := PanelContainer.new()


func _ready() -> void:
	var column := VBoxContainer.new()
	column.theme = PanelTheme.create()
	column.position = Vector2(20.0, 16.0)
	column.mouse_filter = Control.MOUSE_FILTER_IGNORE
	add_child(column)
	column.add_child(_bar())
	var text := Label.new()
	text.text = caption
	text.add_theme_color_override(&"font_outline_color", Color(0.0, 0.0, 0.0, 0.35))
	text.add_theme_constant_override(&"outline_size", 5)
	column.add_child(text)
	if source != null:
		_show_note(column.theme)
		source.grown.connect(func(_volume: LumivoxVolume) -> void: _note.hide())


func _bar() -> Control:
	var bar := HBoxContainer.new()
	bar.add_theme_constant_override(&"separation", 4)
	bar.mouse_filter = Control.MOUSE_FILTER_IGNORE
	var current := get_tree().current_scene.scene_file_path if get_tree().current_scene != null else ""
	for title in SCENES:
		var button := Button.new()
		button.text = title
		button.focus_mode = Control.FOCUS_NONE
		var here := SCENES[title] == current
		for state: StringName in [&"normal", &"hover", &"pressed"]:
			var box := bar_box(here, state == &"hover")
			button.add_theme_stylebox_override(state, box)
		if not here:
			button.pressed.connect(_switch_to.bind(SCENES[title]))
		bar.add_child(button)
	return bar


## The look of a button of the bar.
func bar_box(here: bool, hovered: bool) -> StyleBox:
	var box := StyleBoxFlat.new()
	box.bg_color = Color(PanelTheme.ACCENT.darkened(0.35), 0.95) if here \
			else Color(PanelTheme.GLASS.lightened(0.08 if hovered else 0.0), 0.82)
	box.set_corner_radius_all(7)
	box.content_margin_left = 12.0
	box.content_margin_right = 12.0
	box.content_margin_top = 6.0
	box.content_margin_bottom = 6.0
	return box


func _show_note(theme: Theme) -> void:
	_note.theme = theme
	var row := HBoxContainer.new()
	row.add_theme_constant_override(&"separation", 12)
	var text := Label.new()
	text.text = "Growing the head phantom…"
	row.add_child(text)
	var bar := ProgressBar.new()
	bar.indeterminate = true
	bar.show_percentage = false
	bar.custom_minimum_size = Vector2(120.0, 6.0)
	bar.size_flags_vertical = Control.SIZE_SHRINK_CENTER
	row.add_child(bar)
	_note.add_child(row)
	_note.set_anchors_and_offsets_preset(Control.PRESET_BOTTOM_LEFT, Control.PRESET_MODE_MINSIZE, 20)
	_note.grow_vertical = Control.GROW_DIRECTION_BEGIN
	add_child(_note)


func _switch_to(path: String) -> void:
	get_tree().change_scene_to_file(path)
