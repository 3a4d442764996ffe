@icon("../icons/lumivox_volume_panel.svg")
class_name LumivoxVolumePanel
extends PanelContainer
## A panel for a running game: opens scans, and sets look, light and clipping of one [LumivoxVolume3D].
##
## Put it into a [CanvasLayer], and set [member volume_node] and, for exposure and denoising, [member effect].

## Emitted when a scan that was opened is shown.
signal volume_opened(volume: LumivoxVolume)

const PanelTheme := preload("panel_theme.gd")
const RangeRow := preload("range_row.gd")
const ClipRow := preload("clip_row.gd")
const PresetGallery := preload("preset_gallery.gd")

## Seconds between two readings of the sample count.
const STATUS_INTERVAL := 0.2

## The node that is edited.
@export var volume_node: LumivoxVolume3D:
	set = set_volume_node
## The effect that is set; without one its rows are hidden.
@export var effect: LumivoxEffect:
	set = set_effect
## The key that hides and shows the panel.
@export var hide_key := KEY_H
## Whether the panel follows the project's look instead of its own.
@export var use_project_theme := false

var _density := RangeRow.new("Density", 0.05, 20.0, 0.01, "", true)
var _exposure := RangeRow.new("Exposure", -4.0, 4.0, 0.05, " EV")
var _denoise := CheckBox.new()
var _kept_light := CheckBox.new()
var _clip: Array[ClipRow] = []
var _importer: LumivoxImporter
## The node that [member _importer] loads a scan for.
var _receiver: LumivoxVolume3D
var _since_status := 0.0

@onready var _title: Label = %Title
@onready var _detail: Label = %Detail
@onready var _open: MenuButton = %Open
@onready var _progress: ProgressBar = %Progress
@onready var _stage: Label = %Stage
@onready var _cancel: Button = %Cancel
@onready var _work: Control = %Work
@onready var _message: Label = %Message
@onready var _preset: OptionButton = %Preset
@onready var _rows: VBoxContainer = %Rows
@onready var _editor: LumivoxTransferFunctionEditor = %TransferFunctionEditor
@onready var _samples: ProgressBar = %Samples
@onready var _status: Label = %Status
@onready var _dialog: FileDialog = %FileDialog


func _ready() -> void:
	if not use_project_theme:
		theme = PanelTheme.create()
	for preset in LumivoxVolume3D.preset_names():
		_preset.add_item(PresetGallery.title(preset))
		_preset.set_item_metadata(-1, preset)
	_preset.item_selected.connect(_on_preset_selected)
	_editor.apply_presets = false
	_editor.preset_chosen.connect(apply_preset)
	for row: RangeRow in [_density, _exposure]:
		_rows.add_child(row)
	_density.value_changed.connect(_on_density)
	_exposure.value_changed.connect(_on_exposure)
	_denoise.text = "Denoise"
	_denoise.tooltip_text = "Filters the noise out of the image at rest; a little too soft until it has 256 samples."
	_denoise.toggled.connect(_on_denoise)
	_kept_light.text = "Kept light"
	_kept_light.tooltip_text = "Keeps light in the volumes: clean pictures while something moves."
	_kept_light.toggled.connect(_on_kept_light)
	for switch: CheckBox in [_denoise, _kept_light]:
		switch.focus_mode = Control.FOCUS_NONE
		_rows.add_child(switch)
	for axis: Array in [["Clip  side", "R", "L"], ["Clip  height", "F", "H"], ["Clip  depth", "P", "A"]]:
		var row := ClipRow.new(axis[0] as String, axis[1] as String, axis[2] as String)
		row.range_changed.connect(_on_clip.bind(_clip.size()))
		_clip.append(row)
		_rows.add_child(row)
	_open.get_popup().id_pressed.connect(_on_open)
	_dialog.file_selected.connect(_on_file_selected)
	_dialog.dir_selected.connect(_on_file_selected)
	_cancel.pressed.connect(cancel)
	get_window().files_dropped.connect(open)
	_refresh()


func _exit_tree() -> void:
	cancel()
	if get_window() != null and get_window().files_dropped.is_connected(open):
		get_window().files_dropped.disconnect(open)


func _unhandled_key_input(event: InputEvent) -> void:
	var key := event as InputEventKey
	if key != null and key.pressed and not key.echo and key.keycode == hide_key:
		visible = not visible
		get_viewport().set_input_as_handled()


func _process(delta: float) -> void:
	_since_status += delta
	if visible and _since_status >= STATUS_INTERVAL:
		_since_status = 0.0
		_show_status()
		_show_clip()


## Edits another node; null empties the panel.
func set_volume_node(value: LumivoxVolume3D) -> void:
	volume_node = value
	_refresh()


## Sets another effect.
func set_effect(value: LumivoxEffect) -> void:
	effect = value
	_refresh()


## Shows what the node holds now, for code that has changed it.
func refresh() -> void:
	_refresh()


## Opens files or a folder in the background; the node shows the scan when it is there.
func open(paths: PackedStringArray, options: Dictionary = {}) -> void:
	if volume_node == null or paths.is_empty():
		return
	_abandon()
	_say("")
	_receiver = volume_node
	_importer = LumivoxImporter.new()
	_importer.progress.connect(_on_progress)
	_importer.finished.connect(_on_finished)
	_importer.failed.connect(_on_failed)
	_importer.cancelled.connect(_end_work)
	_stage.text = "Opening %s" % paths[0].trim_suffix("/").get_file()
	_progress.value = 0.0
	_work.show()
	_open.disabled = true
	var problem := _importer.start(paths, options)
	if problem != OK:
		_on_failed("This could not be opened: %s." % error_string(problem))


## Stops opening.
func cancel() -> void:
	if _importer != null:
		_importer.cancel()


## Stops opening, and hears no more of it: it ends only after something else was begun.
func _abandon() -> void:
	cancel()
	if _importer != null:
		_importer.progress.disconnect(_on_progress)
		_importer.finished.disconnect(_on_finished)
		_importer.failed.disconnect(_on_failed)
		_importer.cancelled.disconnect(_end_work)
		_importer = null


## Applies a preset to the node: medium and transfer function.
func apply_preset(preset: String) -> void:
	if volume_node != null:
		volume_node.apply_preset(preset)
		_refresh()


func _refresh() -> void:
	if not is_node_ready():
		return
	var usable := volume_node != null and volume_node.volume != null and not volume_node.volume.is_empty()
	_editor.volume = volume_node.volume if usable else null
	_editor.transfer_function = volume_node.transfer_function if volume_node != null else null
	_preset.disabled = not usable
	_exposure.visible = effect != null
	_denoise.visible = effect != null
	_kept_light.visible = effect != null
	if effect != null:
		_exposure.show_value(effect.exposure)
		_denoise.set_pressed_no_signal(effect.denoise)
		_kept_light.set_pressed_no_signal(effect.kept_light)
	if volume_node == null:
		return
	_density.show_value(volume_node.density)
	_show_clip()
	for i in _preset.item_count:
		if _preset.get_item_metadata(i) == volume_node.preset:
			_preset.select(i)
	if usable:
		_describe(volume_node.volume)


func _describe(volume: LumivoxVolume) -> void:
	var dims := volume.get_dimensions()
	var extent := volume.get_size_m() * 1000.0
	var report := volume.get_report()
	var series: Array = report.get("series", [])
	var chosen: int = report.get("chosen", 0)
	var named: bool = chosen < series.size() and (series[chosen] as Dictionary).get("description", "") != ""
	_title.text = volume.resource_name if volume.resource_name != "" else "Volume"
	_title.tooltip_text = str((series[chosen] as Dictionary).description) if named else ""
	_detail.text = "%d × %d × %d   ·   %.0f × %.0f × %.0f mm" % [dims.x, dims.y, dims.z, extent.x, extent.y, extent.z]


## Scripts and animations may move the clip box too.
func _show_clip() -> void:
	if volume_node != null:
		for i in _clip.size():
			_clip[i].show_range(volume_node.clip_min[i], volume_node.clip_max[i])


func _show_status() -> void:
	if not Engine.has_singleton(&"Lumivox"):
		_status.text = ""
		return
	var status: Dictionary = Engine.get_singleton(&"Lumivox").call(&"get_status", get_viewport())
	if status.is_empty():
		_status.text = ""
		return
	var samples: int = status.get("samples", 0)
	var target: int = maxi(status.get("target", 1) as int, 1)
	_samples.max_value = target
	_samples.value = samples
	if status.get("converged", false):
		_status.text = "%d samples, converged" % samples
	else:
		_status.text = "%d / %d samples   ·   %.1f ms" % [samples, target, status.get("ms_per_frame", 0.0)]


func _say(text: String) -> void:
	_message.text = text
	_message.visible = text != ""


func _on_preset_selected(index: int) -> void:
	apply_preset(_preset.get_item_metadata(index) as String)


func _on_density(value: float) -> void:
	if volume_node != null:
		volume_node.density = value


func _on_exposure(value: float) -> void:
	if effect != null:
		effect.exposure = value


func _on_denoise(on: bool) -> void:
	if effect != null:
		effect.denoise = on


func _on_kept_light(on: bool) -> void:
	if effect != null:
		effect.kept_light = on


func _on_clip(low: float, high: float, axis: int) -> void:
	if volume_node == null:
		return
	var from := volume_node.clip_min
	var to := volume_node.clip_max
	from[axis] = low
	to[axis] = high
	volume_node.clip_min = from
	volume_node.clip_max = to


func _on_open(id: int) -> void:
	_dialog.file_mode = FileDialog.FILE_MODE_OPEN_DIR if id == 0 else FileDialog.FILE_MODE_OPEN_FILE
	_dialog.title = "Open a DICOM folder" if id == 0 else "Open a scan"
	_dialog.popup_centered_clamped(Vector2i(820, 560), 0.9)


func _on_file_selected(path: String) -> void:
	open([path])


func _on_progress(stage: String, done: int, total: int) -> void:
	_stage.text = stage
	_progress.indeterminate = total <= 0
	_progress.max_value = maxi(total, 1)
	_progress.value = done


func _on_finished(volume: LumivoxVolume) -> void:
	_end_work()
	if not is_instance_valid(_receiver):
		_say("The scan was loaded, but the node that it was for is gone.")
		return
	_receiver.volume = volume
	_receiver.clip_min = Vector3.ZERO
	_receiver.clip_max = Vector3.ONE
	# The look of the scan before may not suit this one's modality.
	_receiver.apply_preset(PresetGallery.suiting(volume))
	_refresh()
	volume_opened.emit(volume)


func _on_failed(message: String) -> void:
	_end_work()
	_say(message)


func _end_work() -> void:
	_importer = null
	_work.hide()
	_open.disabled = false
