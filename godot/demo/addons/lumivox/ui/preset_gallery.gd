@tool
extends PopupPanel
## The presets as pictures of the volume at hand.

## Emitted when one was chosen.
signal chosen(preset: String)

const PresetThumbnail := preload("preset_thumbnail.gd")
## As wide as it is high, about.
const COLUMNS := 5

var _scroll := ScrollContainer.new()
var _grid := GridContainer.new()
var _buttons: Dictionary[String, Button] = {}
var _volume: LumivoxVolume
var _task := -1
var _pictures: Dictionary[String, Image] = {}
var _stale := true


func _init() -> void:
	_grid.columns = COLUMNS
	_scroll.add_child(_grid)
	add_child(_scroll)
	set_process(false)


func _process(_delta: float) -> void:
	if _task < 0 or not WorkerThreadPool.is_task_completed(_task):
		return
	WorkerThreadPool.wait_for_task_completion(_task)
	_task = -1
	set_process(false)
	for preset: String in _pictures:
		if _buttons.has(preset):
			_buttons[preset].icon = ImageTexture.create_from_image(_pictures[preset])


func _exit_tree() -> void:
	if _task >= 0:
		WorkerThreadPool.wait_for_task_completion(_task)
		_task = -1


## The volume that the pictures show.
func set_volume(volume: LumivoxVolume) -> void:
	if volume != _volume:
		_volume = volume
		_stale = true


## Opens the gallery at [param anchor], in screen coordinates.
func open_at(anchor: Rect2) -> void:
	if _buttons.is_empty():
		_build()
	if _stale and _task < 0:
		_stale = false
		for preset: String in _buttons:
			_buttons[preset].disabled = not is_available(preset, _volume)
			_buttons[preset].icon = _gradient(preset)
		_start_pictures()
	_fit_to_screen()
	popup(on_screen(Rect2i(Vector2i(int(anchor.position.x), int(anchor.end.y)), size), int(anchor.size.y)))


## Where a popup below a control of such a height is wholly on its screen, or window: above the control where there is more room.
func on_screen(wanted: Rect2i, above: int) -> Rect2i:
	var room := _room()
	var below := room.end.y - wanted.position.y
	if wanted.size.y > below and wanted.position.y - above - room.position.y > below:
		wanted.position.y -= above + mini(wanted.size.y, wanted.position.y - above - room.position.y)
	wanted.size = Vector2i(mini(wanted.size.x, room.size.x), mini(wanted.size.y, room.size.y))
	wanted.position = wanted.position.clamp(room.position, (room.end - wanted.size).max(room.position))
	return wanted


## The screen, or the window where popups stay in it.
func _room() -> Rect2i:
	var window := get_parent().get_window()
	return Rect2i(Vector2i.ZERO, window.size) if window.gui_embed_subwindows \
			else DisplayServer.screen_get_usable_rect(window.current_screen)


## As large as the pictures, or as there is room for: no popup is smaller than what it holds, and then that scrolls.
func _fit_to_screen() -> void:
	var wanted := _grid.get_combined_minimum_size()
	_scroll.custom_minimum_size = wanted
	reset_size()
	var room := Vector2(_room().size)
	# Beside them there is the panel's frame.
	var most := room - (Vector2(size) - wanted).max(Vector2.ZERO)
	if wanted.y > most.y:
		wanted.x += _scroll.get_v_scroll_bar().get_combined_minimum_size().x
	_scroll.custom_minimum_size = wanted.min(most)
	reset_size()


## The preset that suits a scan when nobody chose one.
static func suiting(volume: LumivoxVolume) -> String:
	return "mr-head" if volume != null and not volume.is_empty() and volume.get_unit() != "HU" else "ct-muscle"


## Whether a preset can be had: those for MR place themselves by a scan's values.
static func is_available(preset: String, volume: LumivoxVolume) -> bool:
	return preset.begins_with("ct-") or (volume != null and not volume.is_empty())


## A name as people read it: `ct-bone` becomes `CT bone`.
static func title(preset: String) -> String:
	var words := preset.split("-")
	words[0] = words[0].to_upper() if words[0].length() <= 3 else words[0].capitalize()
	return " ".join(words)


func _build() -> void:
	for preset in LumivoxTransferFunction.preset_names():
		var button := Button.new()
		button.text = title(preset)
		button.flat = true
		button.icon_alignment = HORIZONTAL_ALIGNMENT_CENTER
		button.vertical_icon_alignment = VERTICAL_ALIGNMENT_TOP
		button.custom_minimum_size = Vector2(104.0, 112.0) * maxf(button.get_theme_default_base_scale(), 1.0)
		button.expand_icon = true
		button.pressed.connect(_on_pressed.bind(preset))
		_grid.add_child(button)
		_buttons[preset] = button


func _on_pressed(preset: String) -> void:
	hide()
	chosen.emit(preset)


## What is seen until the pictures are there: the preset's colours.
func _gradient(preset: String) -> Texture2D:
	if not is_available(preset, _volume):
		return null
	var source := LumivoxTransferFunction.preset(preset, _volume)
	var gradient := Gradient.new()
	var low := source.color_values[0]
	var extent := maxf(source.color_values[-1] - low, 1e-6)
	var offsets := PackedFloat32Array()
	for value in source.color_values:
		offsets.append((value - low) / extent)
	gradient.offsets = offsets
	gradient.colors = source.colors
	var texture := GradientTexture2D.new()
	texture.gradient = gradient
	texture.width = PresetThumbnail.SIZE
	texture.height = PresetThumbnail.SIZE
	return texture


func _start_pictures() -> void:
	if _volume == null or _volume.is_empty():
		return
	_pictures = {}
	_task = WorkerThreadPool.add_task(_render_pictures.bind(_volume), false, "Lumivox preset pictures")
	set_process(true)


func _render_pictures(volume: LumivoxVolume) -> void:
	var thumbnail := PresetThumbnail.new(volume)
	var pictures: Dictionary[String, Image] = {}
	for preset in LumivoxTransferFunction.preset_names():
		var image := thumbnail.render(LumivoxTransferFunction.preset(preset, volume))
		if image != null:
			pictures[preset] = image
	_pictures = pictures
